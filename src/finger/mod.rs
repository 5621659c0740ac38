//! Finger mechanics: geometry, springs, transmission; nothing of motors, time or noise.
