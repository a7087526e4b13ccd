//! The world the robots live in, its faults, and a rehearsal of the whole fleet in one thread.
