//! The format, and every lesson that comes with the program.

mod catalogue;
mod documented;
mod faults;
