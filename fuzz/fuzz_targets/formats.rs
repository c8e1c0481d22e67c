#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| impactscope_fuzz::bodies::formats(bytes));
