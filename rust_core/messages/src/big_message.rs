//! Serialisation of the big messages, which keep their bytes.

/// Implements `RosMsg` and `Message` for a type with `from_bytes`, `write` and `len_hint`, whose definition is that of
/// a generated type.
macro_rules! big_message {
    ($type:ident: $generated:ty) => {
        impl rosrust::RosMsg for $type {
            fn encode<W: std::io::Write>(&self, mut w: W) -> std::io::Result<()> {
                let mut out = Vec::with_capacity(self.len_hint());
                self.write(&mut out);
                w.write_all(&out)
            }

            /// Reads to the end of `r`: the message is never part of another one.
            fn decode<R: std::io::Read>(mut r: R) -> std::io::Result<Self> {
                let mut bytes = Vec::new();
                r.read_to_end(&mut bytes)?;
                Ok(Self::from_bytes(std::sync::Arc::new(bytes))?)
            }
        }

        impl rosrust::Message for $type {
            fn msg_definition() -> String {
                <$generated>::msg_definition()
            }

            fn md5sum() -> String {
                <$generated>::md5sum()
            }

            fn msg_type() -> String {
                <$generated>::msg_type()
            }
        }
    };
}

pub(crate) use big_message;
