//! Settings as tables: each property has its field, type, default and key in one row.

/// Defines the settings of a display class or of a part of one, with their defaults, and implements
/// [`Properties`](crate::section::Properties) for them.
///
/// A row is `field: type = default => reader(key, arguments);`, where the reader is a method of
/// [`Section`](crate::section::Section). A field without a reader is set elsewhere. The rows of `inside "Key"` are keys
/// inside of that key, those of `skip` are accepted without effect, and `then` names a method that reads the rest.
macro_rules! properties {
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $($(#[$doc:meta])* $field:ident: $type:ty = $default:expr $(=> $reader:ident($($argument:expr),*))?;)*
        }
        $(inside $key:literal {
            $($(#[$inner_doc:meta])* $inner:ident: $inner_type:ty = $inner_default:expr
                => $inner_reader:ident($($inner_argument:expr),*);)*
        })*
        $(skip $skipped:expr;)?
        $(then $rest:ident;)?
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $name {
            $($(#[$doc])* pub $field: $type,)*
            $($($(#[$inner_doc])* pub $inner: $inner_type,)*)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* $($($inner: $inner_default,)*)* }
            }
        }

        impl $crate::section::Properties for $name {
            fn read_properties(&mut self, section: &mut $crate::section::Section<'_>) {
                $($(section.$reader($($argument,)* &mut self.$field);)?)*
                $({
                    let mut inside = section.child($key);
                    $(inside.$inner_reader($($inner_argument,)* &mut self.$inner);)*
                    inside.finish();
                })*
                $(section.skip(&$skipped);)?
                $(self.$rest(section);)?
            }
        }
    };
}
