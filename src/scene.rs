//! The file a user edits: this finger, this drivetrain, these limits.
