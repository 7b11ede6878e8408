//! OpenEXR of any content: refused in one line, or a picture of finite colours.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|data: &[u8]| -> Corpus {
    if !data.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return Corpus::Reject;
    }
    render_fuzz::check_picture(data);
    Corpus::Keep
});
