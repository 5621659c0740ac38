//! The few numerical tools, each with its measured error.
