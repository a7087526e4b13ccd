//! Printing to stdout. When nobody reads any more (`oxplow plan … | head`), the command ends quietly.

use std::{
    fmt,
    io::{ErrorKind, Write as _, stdout},
};

/// Prints a line as `println!` does.
macro_rules! say {
    ($($argument:tt)*) => { $crate::say::line(format_args!($($argument)*)) };
}
pub(crate) use say;

/// Prints a line.
pub fn line(text: fmt::Arguments<'_>) {
    if let Err(error) = writeln!(stdout(), "{text}")
        && error.kind() == ErrorKind::BrokenPipe
    {
        std::process::exit(0);
    }
}
