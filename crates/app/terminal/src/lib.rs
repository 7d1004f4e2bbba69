//! What the programs `paid` and `paid-robot` have in common on a terminal: exit codes, signals, a full disk.

mod failure;
mod print;
mod stop;
mod terminal;

pub use failure::{EXIT_CODES, Failure};
pub use print::{panic_where_it_fails, write_error, write_out};
pub use stop::{STOPPED, end_with_the_reader, flag, outlive_the_terminal};
pub use terminal::prepared;
