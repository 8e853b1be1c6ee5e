//! Adapters: the Vulkan devices of the machine, what they can do, and the choice of one by name or index.

use crate::error::GpuError;
use wgpu::Features;

/// A Vulkan adapter (a GPU or a software rasteriser), as `scree doctor` lists it.
#[derive(Clone, Debug)]
pub struct Adapter {
    /// Index in [`adapters`], by which it can be chosen.
    pub index: usize,
    /// Name of the adapter.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Whether the adapter is a software rasteriser, which is taken only where the caller allows it.
    pub software: bool,
    /// Maximum size of a buffer, bytes.
    pub max_buffer: u64,
    /// Maximum size of what a kernel can bind of a buffer, bytes.
    pub max_binding: u64,
    /// Memory of a workgroup, bytes.
    pub workgroup_memory: u32,
    /// Maximum number of invocations of a workgroup.
    pub max_invocations: u32,
    /// Least and greatest size of a subgroup; none without subgroup operations.
    pub subgroup: Option<[u32; 2]>,
    /// Names of the optional features that kernels and timers can use and that it has.
    pub features: Vec<&'static str>,
}

/// The optional features, by name.
const FEATURES: [(&str, Features); 6] = [
    ("subgroups", Features::SUBGROUP),
    ("timestamps", Features::TIMESTAMP_QUERY),
    ("f64", Features::SHADER_F64),
    ("i64", Features::SHADER_INT64),
    ("i64 atomics", WIDE_ATOMICS),
    ("float32 atomics", Features::SHADER_FLOAT32_ATOMIC),
];

/// Those that kernels with minima of 64 bits in memory use.
pub(crate) const WIDE_ATOMICS: Features = Features::SHADER_INT64.union(Features::SHADER_INT64_ATOMIC_MIN_MAX);

/// The features that a device is opened with, where the adapter has them.
pub(crate) const USED: Features = Features::SUBGROUP
    .union(Features::TIMESTAMP_QUERY)
    .union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(WIDE_ATOMICS);

impl Adapter {
    fn of(index: usize, adapter: &wgpu::Adapter) -> Adapter {
        let (info, limits, has) = (adapter.get_info(), adapter.limits(), adapter.features());
        let has_subgroups = has.contains(Features::SUBGROUP);
        Adapter {
            index,
            name: info.name,
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
            software: info.device_type == wgpu::DeviceType::Cpu,
            max_buffer: limits.max_buffer_size,
            max_binding: limits.max_storage_buffer_binding_size,
            workgroup_memory: limits.max_compute_workgroup_storage_size,
            max_invocations: limits.max_compute_invocations_per_workgroup,
            subgroup: has_subgroups.then_some([info.subgroup_min_size, info.subgroup_max_size]),
            features: FEATURES.iter().filter(|(_, f)| has.contains(*f)).map(|(name, _)| *name).collect(),
        }
    }
}

/// The choice of an adapter.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Choice {
    /// The first hardware adapter.
    #[default]
    Hardware,
    /// The first hardware adapter, or else the first software one.
    Any,
    /// The adapter of this index in [`adapters`], or the only one whose name has this text in it, in any case.
    Named(String),
}

/// All Vulkan adapters with wgpu's handles, hardware before software.
fn found() -> Vec<(Adapter, wgpu::Adapter)> {
    let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
    desc.backends = wgpu::Backends::VULKAN;
    // Counts of indirect dispatches come from our own kernels, which keep them within the limits.
    desc.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    let instance = wgpu::Instance::new(desc);
    let mut list = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    list.sort_by_key(|a| a.get_info().device_type == wgpu::DeviceType::Cpu);
    list.into_iter().enumerate().map(|(k, a)| (Adapter::of(k, &a), a)).collect()
}

/// All Vulkan adapters of this machine, hardware before software.
pub fn adapters() -> Vec<Adapter> {
    found().into_iter().map(|(adapter, _)| adapter).collect()
}

/// Whether this machine may have a hardware adapter, by the device files of drivers: to list the adapters takes some tenths of
/// a second. On other systems than Linux it always may.
pub fn may_have_hardware() -> bool {
    const NODES: [&str; 5] = ["/dev/dri", "/dev/nvidiactl", "/dev/dxg", "/dev/mali0", "/dev/kgsl-3d0"];
    !cfg!(target_os = "linux") || NODES.iter().any(|node| std::path::Path::new(node).exists())
}

/// Choose an adapter.
///
/// # Errors
/// [`GpuError::NoAdapter`], or [`GpuError::Choice`] if the name or index does not stand for one adapter.
pub(crate) fn choose(choice: &Choice) -> Result<(Adapter, wgpu::Adapter), GpuError> {
    let mut list = found();
    let place = match choice {
        Choice::Hardware => list.iter().position(|(a, _)| !a.software),
        Choice::Any => (!list.is_empty()).then_some(0),
        Choice::Named(wanted) if !list.is_empty() => {
            let all: Vec<Adapter> = list.iter().map(|(a, _)| a.clone()).collect();
            Some(place_of(wanted, &all)?)
        }
        Choice::Named(_) => None,
    };
    let place = place.ok_or(GpuError::NoAdapter { software: *choice != Choice::Hardware })?;
    Ok(list.swap_remove(place))
}

/// Place of the adapter that a name or an index stands for.
fn place_of(wanted: &str, all: &[Adapter]) -> Result<usize, GpuError> {
    let fault = |fault| {
        let known: Vec<String> = all.iter().map(|a| format!("{}: {}", a.index, a.name)).collect();
        GpuError::Choice { wanted: wanted.into(), fault, known: known.join(", ") }
    };
    if wanted.trim().is_empty() {
        return Err(fault("expected the index of an adapter or a part of its name, not"));
    }
    if let Ok(index) = wanted.parse::<usize>() {
        return if index < all.len() { Ok(index) } else { Err(fault("there is no adapter of index")) };
    }
    let has = |a: &&Adapter| a.name.to_lowercase().contains(&wanted.to_lowercase());
    let mut named = all.iter().filter(has);
    match (named.next(), named.next()) {
        (Some(a), None) => Ok(a.index),
        (None, _) => Err(fault("there is no adapter with the name")),
        _ => Err(fault("there are several adapters with the name")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(index: usize, name: &str) -> Adapter {
        let (driver, features) = (String::new(), vec![]);
        let name = name.into();
        let (max_buffer, max_binding, workgroup_memory, max_invocations) = (0, 0, 0, 0);
        Adapter {
            index,
            name,
            driver,
            software: false,
            max_buffer,
            max_binding,
            workgroup_memory,
            max_invocations,
            subgroup: None,
            features,
        }
    }

    #[test]
    fn an_adapter_is_chosen_by_index_or_by_a_part_of_its_name() {
        let all = [adapter(0, "Radeon RX 7900"), adapter(1, "GeForce 4090"), adapter(2, "GeForce 4090")];
        assert_eq!(place_of("1", &all), Ok(1));
        assert_eq!(place_of("radeon", &all), Ok(0));
        let several = place_of("geforce", &all).unwrap_err().to_string();
        assert!(several.contains("several") && several.contains("2: GeForce 4090"), "{several}");
        let none = place_of("arc", &all).unwrap_err().to_string();
        assert!(none.contains("`arc`") && none.contains("0: Radeon RX 7900"), "{none}");
        for empty in ["", " "] {
            let said = place_of(empty, &all[..1]).unwrap_err().to_string();
            assert!(said.contains("expected the index of an adapter or a part of its name, not `"), "{said}");
        }
        assert!(place_of("3", &all).unwrap_err().to_string().contains("index `3`"));
    }
}
