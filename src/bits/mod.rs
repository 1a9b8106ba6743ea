//! Bytes, one field at a time: a reader that says where it stands, a writer, variable-length integers.

#[cfg(feature = "encode")]
mod crc;
mod reader;
mod writer;

#[cfg(feature = "encode")]
pub(crate) use crc::crc32;
pub(crate) use reader::Reader;
pub(crate) use writer::Writer;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_written_is_read_back(a: u8, b: u64, c: i64, d: f64, e: f32) {
            let mut w = Writer::default();
            w.u8(a);
            w.varint(b);
            w.signed(c);
            w.f64(d);
            w.f32(e);
            let bytes = w.into_bytes();
            let mut r = Reader::new(&bytes, *b"TEST");
            prop_assert_eq!(r.u8("a").unwrap(), a);
            prop_assert_eq!(r.varint("b").unwrap(), b);
            prop_assert_eq!(r.signed("c").unwrap(), c);
            prop_assert_eq!(r.f64("d").unwrap().to_bits(), d.to_bits());
            prop_assert_eq!(r.f32("e").unwrap().to_bits(), e.to_bits());
            prop_assert!(r.finish().is_ok());
        }

        #[test]
        fn any_bytes_give_a_varint_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..12)) {
            if let Ok(value) = Reader::new(&bytes, *b"TEST").varint("n") {
                let mut w = Writer::default();
                w.varint(value);
                prop_assert!(bytes.starts_with(&w.into_bytes()));
            }
        }
    }

    #[test]
    fn a_varint_of_more_bytes_than_needed_is_refused() {
        assert!(Reader::new(&[0x80, 0x00], *b"TEST").varint("n").is_err());
        assert!(Reader::new(&[0xff; 11], *b"TEST").varint("n").is_err());
    }
}
