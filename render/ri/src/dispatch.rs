//! A request's name → its arguments, read as the table says → its call.

use crate::arguments::{Arguments, InRow};
use crate::requests::{Request, nearest};
use crate::ri::{Fail, Ri};
use crate::table::requests;

/// A failure, and whether it lies in the arguments rather than in the call.
pub(crate) struct Placed {
    pub(crate) fail: Fail,
    pub(crate) in_arguments: bool,
}

impl From<Fail> for Placed {
    fn from(fail: Fail) -> Placed {
        Placed { fail, in_arguments: true }
    }
}

/// Read over a request that is not known. The specification asks to go on; a name near a known one is most likely a slip.
pub(crate) fn pass_over(arguments: &mut Arguments<'_>, name: &str) -> Result<(), Placed> {
    let key = format!("request {name}");
    // The nearest name is looked for once.
    if !arguments.has_warned(&key) {
        let near = nearest(name).map_or(String::new(), |known| format!(", did you mean `{known}`?"));
        arguments.warn(&key, &format!("unknown request `{name}`{near}; it is passed over"));
    }
    Ok(arguments.pass_over()?)
}

/// Read arguments of one kind into variables of their names.
macro_rules! read {
    ($from:ident, numbers $what:literal ($($arg:ident: $ty:ty),+)) => {
        let row: [f32; 0 $(+ <$ty as InRow>::WIDTH)+] = $from.numbers($what)?;
        let rest = &mut &row[..];
        $(let $arg = <$ty>::take(rest);)+
    };
    ($from:ident, list $what:literal ($($arg:ident: $ty:ty),+)) => {
        read!($from, numbers $what ($($arg: $ty),+));
    };
    ($from:ident, lens ($($arg:ident: $ty:ty),+)) => {
        let [$($arg),+] = $from.lens()?;
    };
    ($from:ident, declaration ($name:ident: $name_ty:ty, $declaration:ident: $declaration_ty:ty)) => {
        let ($name, $declaration) = &$from.declaration()?;
    };
    ($from:ident, text ($arg:ident: $ty:ty)) => {
        let $arg = &$from.text()?;
    };
    ($from:ident, handle ($arg:ident: $ty:ty)) => {
        let $arg = &$from.handle()?;
    };
    ($from:ident, text_pair ($arg:ident: $ty:ty)) => {
        let [first, second] = &$from.text_pair()?;
        let $arg = [first.as_str(), second.as_str()];
    };
    ($from:ident, colour_samples ($to_rgb:ident: $to_ty:ty, $from_rgb:ident: $from_ty:ty)) => {
        let ($to_rgb, $from_rgb) = $from.colour_samples()?;
    };
    ($from:ident, $kind:ident ($name:ident: $name_ty:ty, $params:ident: $params_ty:ty)) => {
        let (name, $params) = $from.$kind()?;
        let $name = &name;
    };
    ($from:ident, $kind:ident ($arg:ident: $ty:ty)) => {
        let $arg = $from.$kind()?;
    };
}

macro_rules! dispatch {
    ($(#[doc = $doc:literal] $name:ident [$($where:ident)+]
       $(=> $method:ident($($kind:ident $($what:literal)? ($($arg:ident: $ty:ty),+))*))?;)*) => {
        /// Read a request's arguments and make its call. Arguments are read to the end first, so that a broken stream makes no
        /// half call. Panics for a request that the reader does itself.
        pub(crate) fn dispatch(arguments: &mut Arguments<'_>, ri: &mut dyn Ri, request: Request) -> Result<(), Placed> {
            match request {
                $($(
                    Request::$name => {
                        $(read!(arguments, $kind $($what)? ($($arg: $ty),+));)*
                        arguments.end_of(stringify!($name))?;
                        ri.$method($($($arg),+),*).map_err(|fail| Placed { fail, in_arguments: false })
                    }
                )?)*
                Request::ArchiveEnd => Err(Fail::new("`ArchiveEnd` without `ArchiveBegin`").into()),
                _ => unreachable!("a request of the reader"),
            }
        }
    };
}
requests!(dispatch);
