//! Each format against files that other libraries wrote (`assets/test_files/make_formats.py`), and
//! all of them against bytes that are not as they should be.

mod arrays;
mod helpers;
mod hostile;
mod lvm;
mod matlab;
mod numpy;
mod sheets;
mod sound;
mod tdms;
mod uff;
mod wrapped;
