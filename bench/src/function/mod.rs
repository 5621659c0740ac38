//! Tasks `sqrt`, `sin`, `sin_cos`, `atan2`, `recip`: the functions that the methods stand on.
