//! Layout: the rows of Rust columns and of WGSL arrays are the same bytes. Checked by naga's reflection of the kernels.

pub use bytemuck;
use wgpu::naga::proc::Layouter;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};
use wgpu::naga::{AddressSpace, Handle, Module, StorageAccess, Type, TypeInner, front};

/// A storage buffer that a kernel binds.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// Number of the binding.
    pub binding: u32,
    /// Name of the variable.
    pub name: String,
    /// Size of a row (of an element of its array), bytes.
    pub width: u32,
    /// Whether the kernel writes it.
    pub is_written: bool,
}

/// A Rust struct whose rows kernels read as the WGSL struct of the same name; made by [`wgsl_rows!`](crate::wgsl_rows).
pub trait WgslRow: bytemuck::Pod {
    /// Name of the struct.
    const NAME: &'static str;
    /// Name and offset of each field, and last the struct's end.
    const FIELDS: &'static [(&'static str, usize)];
}

/// Declare structs whose rows kernels read as WGSL structs of the same names, with the offsets of their fields.
#[macro_export]
macro_rules! wgsl_rows {
    ($($(#[$doc:meta])* $vis:vis struct $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, $crate::layout::bytemuck::Pod, $crate::layout::bytemuck::Zeroable)]
        #[repr(C)]
        #[bytemuck(crate = "gpu::layout::bytemuck")]
        $vis struct $name { $($(#[$field_doc])* pub $field: $type,)* }

        impl $crate::layout::WgslRow for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [(&'static str, usize)] = &[
                $((stringify!($field), std::mem::offset_of!($name, $field)),)*
                ("(end)", std::mem::size_of::<$name>()),
            ];
        }
    )*};
}

/// Parse and validate a kernel.
///
/// # Errors
/// The fault, with its line and column.
pub(crate) fn parse(name: &str, text: &str) -> Result<Module, String> {
    let module = front::wgsl::parse_str(text).map_err(|e| e.emit_to_string_with_path(text, name))?;
    let validated = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module);
    validated.map_err(|e| e.emit_to_string_with_path(text, name))?;
    Ok(module)
}

/// The storage buffers that a kernel binds in group 0, by their numbers.
pub(crate) fn slots(module: &Module) -> Vec<Slot> {
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).expect("the module is valid");
    let slot = |v: &wgpu::naga::GlobalVariable| {
        let (AddressSpace::Storage { access }, Some(at)) = (v.space, &v.binding) else { return None };
        let width = match module.types[v.ty].inner {
            TypeInner::Array { stride, .. } => stride,
            _ => layouter[v.ty].size,
        };
        let is_written = access.contains(StorageAccess::STORE);
        Some(Slot { binding: at.binding, name: v.name.clone().unwrap_or_default(), width, is_written })
    };
    let mut slots: Vec<Slot> = module.global_variables.iter().filter_map(|(_, v)| slot(v)).collect();
    slots.sort_by_key(|s| s.binding);
    slots
}

/// Check a row of Rust against the struct of the same name in a kernel.
///
/// # Errors
/// What differs: the struct is missing, or a field's name or offset, or the size.
pub fn check<R: WgslRow>(text: &str) -> Result<(), String> {
    let module = parse(R::NAME, text)?;
    let named = |(handle, ty): (Handle<Type>, &Type)| (ty.name.as_deref() == Some(R::NAME)).then_some(handle);
    let handle = module.types.iter().find_map(named).ok_or(format!("there is no struct `{}`", R::NAME))?;
    let TypeInner::Struct { members, span } = &module.types[handle].inner else {
        return Err(format!("`{}` is no struct", R::NAME));
    };
    let mut fields: Vec<(&str, usize)> =
        members.iter().map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize)).collect();
    fields.push(("(end)", *span as usize));
    if fields == R::FIELDS {
        return Ok(());
    }
    Err(format!("`{}` is {:?} in Rust and {fields:?} in WGSL", R::NAME, R::FIELDS))
}
