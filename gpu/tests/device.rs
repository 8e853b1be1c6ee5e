//! Devices: their choice, their faults, buffers, commands, times and read-back.

use crate::{Bench, benches, open};
use gpu::{Buffer, Choice, Commands, Count, Device, GpuError, Kernels, Work, adapters};

/// Twice each value.
const DOUBLE: &str = "
@group(0) @binding(0) var<storage, read_write> values: array<u32>;
@group(0) @binding(1) var<storage, read> params: array<u32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&values) {
        values[id.x] = values[id.x] * params[0];
    }
}
";

#[test]
fn an_adapter_opens_by_its_index_and_its_name() {
    let Some(first) = adapters().into_iter().next() else { return };
    assert!(first.max_buffer > 0 && first.max_invocations >= 256 && !first.driver.is_empty());
    for wanted in [first.index.to_string(), first.name.clone()] {
        assert_eq!(Device::open(&Choice::Named(wanted)).unwrap().adapter.name, first.name);
    }
    let wrong = Device::open(&Choice::Named("no such thing".into())).err().unwrap();
    assert!(matches!(&wrong, GpuError::Choice { known, .. } if known.contains(&first.name)), "{wrong}");
}

#[test]
fn the_software_adapter_is_never_taken_for_hardware() {
    match Device::open(&Choice::Hardware) {
        Ok(device) => assert!(!device.adapter.software),
        Err(error) => assert_eq!(error, GpuError::NoAdapter { software: false }),
    }
}

#[test]
fn a_kernel_that_does_not_compile_is_named_with_the_place_of_its_fault() {
    for Bench { device, kernels } in benches() {
        for (text, expected) in [
            ("fn main() {\n    let x: u32 = 1.5;\n}", "bad:2:"),
            ("#import nothing\n", "unknown part `nothing`"),
            ("@compute @workgroup_size(1)\nfn other() {}", "main"),
            (
                "@group(0) @binding(1) var<storage> a: array<u32>;\n@compute @workgroup_size(1)\nfn main() { _ = a[0]; }",
                "from 0",
            ),
            ("@compute @workgroup_size(100000)\nfn main() {}", "Workgroup size"),
        ] {
            let error = kernels.get(device, "bad", text, &[]).err().unwrap();
            assert!(matches!(&error, GpuError::Kernel { kernel, .. } if kernel == "bad"), "{error}");
            assert!(error.to_string().contains(expected), "{error}");
        }
        device.check().unwrap();
    }
}

#[test]
fn a_kernel_is_compiled_once() {
    for Bench { device, .. } in benches() {
        let kernels = gpu::Kernels::default();
        assert!(kernels.is_empty());
        for _ in 0..3 {
            kernels.get(device, "double", DOUBLE, &[]).unwrap();
        }
        assert_eq!(kernels.len(), 1);
    }
}

#[test]
fn several_threads_compile_at_once_and_each_fault_is_its_own_kernel_s() {
    for Bench { device, .. } in benches() {
        let (kernels, names) = (Kernels::default(), ["one", "two", "three", "four", "five", "six"]);
        // A fault of every other that only the device finds.
        let sizes = [1, 100_000, 2, 200_000, 3, 300_000];
        let text = |size: u32| format!("@compute @workgroup_size({size})\nfn main() {{}}");
        let texts = sizes.map(text);
        let all: Vec<(&str, &str)> = names.into_iter().zip(texts.iter().map(String::as_str)).collect();
        std::thread::scope(|scope| {
            for (name, text) in &all {
                let kernels = &kernels;
                scope.spawn(move || match kernels.get(device, name, text, &[]) {
                    Ok(_) => assert!(["one", "three", "five"].contains(name), "{name} is compiled"),
                    Err(error) => {
                        assert!(["two", "four", "six"].contains(name), "{name}: {error}");
                        assert!(matches!(&error, GpuError::Kernel { kernel, .. } if kernel == name), "{name}: {error}");
                    }
                });
            }
        });
        assert_eq!(kernels.len(), 3);
        let error = kernels.compile_all(device, &all, &[]).unwrap_err();
        assert!(matches!(&error, GpuError::Kernel { kernel, .. } if kernel == "two"), "the first fault: {error}");
        kernels.compile_all(device, &[all[0], all[2]], &[]).unwrap();
        assert_eq!(kernels.len(), 3);
        device.check().unwrap();
    }
}

#[test]
fn a_buffer_that_is_too_large_is_named_with_its_size() {
    for Bench { device, .. } in benches() {
        let error = Buffer::<u32>::zeros(device, "impulses", usize::MAX / 8).err().unwrap();
        let GpuError::TooLarge { buffer, bytes, limit } = &error else { panic!("{error}") };
        assert!(buffer == "impulses" && bytes > limit, "{error}");
        let mut grows = Buffer::of(device, "grows", &[7u32]).unwrap();
        assert!(grows.reserve(device, usize::MAX / 16).is_err());
        assert_eq!(grows.read(device, 1).unwrap(), [7], "the buffer is as it was");
    }
}

#[test]
fn buffers_take_no_more_memory_than_they_may() {
    // A device of its own: the limit is that of all of its buffers.
    let Some(Bench { device, .. }) = open(true) else { return };
    device.limit_memory(5000);
    let first = Buffer::<u32>::zeros(&device, "first", 500).unwrap();
    let kept = first.clone();
    let error = Buffer::<u32>::zeros(&device, "second", 1000).err().unwrap();
    assert!(matches!(&error, GpuError::Limit { buffer, bytes: 4000, limit: 5000 } if buffer == "second"), "{error}");
    // Clones are the same memory, and what does not fit has taken none.
    drop(first);
    assert!(Buffer::<u32>::zeros(&device, "second", 1000).is_err());
    drop(kept);
    let mut second = Buffer::of(&device, "second", &[7u32; 500]).unwrap();
    assert_eq!(device.most_memory(), 2000);
    // Without room to spare it grows as far as it must, and what is read back counts.
    second.reserve(&device, 700).unwrap();
    assert_eq!(second.capacity(), 700);
    assert_eq!(device.most_memory(), 4800);
    assert_eq!(second.read(&device, 500).unwrap(), [7; 500]);
    assert!(second.read(&device, 600).is_err());
}

#[test]
fn a_lost_device_says_so() {
    let Some(Bench { device, kernels }) = open(true) else { return };
    let buffer = Buffer::of(&device, "kept", &[1u32, 2]).unwrap();
    let mut commands = Commands::new();
    commands.clear(&buffer);
    device.lose();
    // The driver tells of it when it is asked next.
    let _ = device.wait();
    let lost = |error: Option<GpuError>| assert!(matches!(&error, Some(GpuError::Lost(_))), "{error:?}");
    lost(device.check().err());
    lost(commands.submit(&device).err());
    lost(buffer.read(&device, 2).err());
    lost(Buffer::<u32>::zeros(&device, "new", 8).err());
    lost(kernels.get(&device, "double", DOUBLE, &[]).err());
}

#[test]
fn a_buffer_grows_and_keeps_what_it_holds() {
    for Bench { device, .. } in benches() {
        let rows: Vec<u32> = (0..1000).collect();
        let mut buffer = Buffer::of(device, "grows", &rows).unwrap();
        assert!(!buffer.reserve(device, 1000).unwrap());
        assert!(buffer.reserve(device, 1001).unwrap());
        assert!(buffer.capacity() >= 1500);
        assert_eq!(buffer.read(device, 1000).unwrap(), rows);
        let bytes: Vec<u8> = vec![1, 2, 3, 4, 5, 6, 7];
        assert_eq!(Buffer::of(device, "bytes", &bytes).unwrap().read(device, 7).unwrap(), bytes);
    }
}

#[test]
fn commands_run_in_order_in_one_submission_and_can_be_submitted_again() {
    for Bench { device, kernels } in benches() {
        let double = kernels.get(device, "double", DOUBLE, &[]).unwrap();
        let values = Buffer::of(device, "values", &[1u32, 2, 3]).unwrap();
        let kept = Buffer::zeros(device, "kept", 3).unwrap();
        let mut commands = Commands::new();
        commands.stage("double");
        for _ in 0..10 {
            commands.dispatch(device, &double, &[values.bind()], &[2], Work::Groups(1));
        }
        commands.stage("copy");
        commands.copy(&values, &kept, 3);
        commands.stage("clear, triple");
        commands.clear(&values);
        commands.dispatch(device, &double, &[kept.bind()], &[3], Work::Groups(1));
        assert_eq!(commands.n_dispatches(), 11);
        let times = commands.submit(device).unwrap().wait(device).unwrap();
        assert_eq!(kept.read(device, 3).unwrap(), [3 * 1024, 6 * 1024, 9 * 1024]);
        assert_eq!(values.read(device, 3).unwrap(), [0, 0, 0]);
        if device.adapter.features.contains(&"timestamps") {
            let times = times.unwrap();
            assert_eq!(times.iter().map(|t| t.0).collect::<Vec<_>>(), ["double", "copy", "clear, triple"]);
            assert!(times.iter().all(|t| (0.0..60.0).contains(&t.1)) && times[0].1 > 0.0, "{times:?}");
        }
        commands.submit(device).unwrap();
        assert_eq!(kept.read(device, 3).unwrap(), [0, 0, 0]);
    }
}

/// Rounds that take long, of a stage that is known to after the first time.
#[test]
fn what_keeps_a_device_long_is_cut_into_submissions() {
    let text = "
        @group(0) @binding(0) var<storage, read_write> values: array<u32>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            var x = values[id.x];
            for (var i = 0u; i < 60000u; i++) { x = x * 1664525u + 1013904223u; }
            values[id.x] = x;
        }";
    for has_timestamps in [true, false] {
        let Some(Bench { device, .. }) = open(true) else { return };
        let device = if has_timestamps { device } else { device.without_timestamps() };
        let kernel = Kernels::default().get(&device, "rounds", text, &[]).unwrap();
        let values = Buffer::of(&device, "values", &[1u32; 64]).unwrap();
        let record = |n: usize| {
            let mut commands = Commands::new();
            commands.stage("rounds");
            (0..n).for_each(|_| commands.dispatch(&device, &kernel, &[values.bind()], &[], Work::Groups(1)));
            commands
        };
        let started = std::time::Instant::now();
        record(1).submit(&device).unwrap().wait(&device).unwrap();
        // As long as four tenths of a second, whatever the device; of a slow one at least 20 dispatches.
        let n = ((0.4 / started.elapsed().as_secs_f64()) as usize).clamp(20, 20_000);
        let long = record(n);
        long.submit(&device).unwrap().wait(&device).unwrap();
        long.observe(&device, 1.0);
        let again = long.submit(&device).unwrap();
        assert!((10..=n).contains(&again.n_submissions()), "{}", again.n_submissions());
        again.wait(&device).unwrap();
        // Lists of which the time is known are submitted together, as far as it goes.
        let short = record(3);
        short.submit(&device).unwrap().unobserved().wait(&device).unwrap();
        short.observe(&device, 0.03);
        let several = Commands::submit_all(&device, [&short, &short, &short]).unwrap();
        assert_eq!(several.n_submissions(), 1);
        several.wait(&device).unwrap();
        assert!(device.longest_submission() > 0.0);
        let round = |x: u32| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let expected = (0..60_000 * (1 + 2 * n + 4 * 3)).fold(1, |x, _| round(x));
        assert_eq!(values.read(&device, 64).unwrap(), [expected; 64], "every command runs once each time");
    }
}

/// What goes to a device and comes from it is counted, and what was sent is timed when it is settled.
#[test]
fn traffic_is_counted_and_sent_commands_are_timed() {
    // A device of its own: other tests read from theirs meanwhile.
    if let Some(Bench { device, kernels }) = &open(true) {
        let before = device.traffic();
        let double = kernels.get(device, "double", DOUBLE, &[]).unwrap();
        let values = Buffer::of(device, "values", &[3u32; 100]).unwrap();
        for _ in 0..3 {
            let mut commands = Commands::new();
            commands.stage("double");
            commands.dispatch(device, &double, &[values.bind()], &[2], Work::Groups(2));
            commands.send(device).unwrap();
        }
        assert_eq!(values.read(device, 100).unwrap(), [24; 100]);
        assert_eq!(device.dispatches()["double"], 3);
        let spent = device.traffic() - before;
        assert_eq!((spent.bytes_written, spent.bytes_read), (400 + 3 * 4, 400));
        assert!(spent.submissions >= 4 && spent.waits >= 1 && spent.wait_seconds >= 0.0, "{spent:?}");
        let stages = device.settle().unwrap();
        assert_eq!(stages.len(), if device.has_timer() { 3 } else { 0 });
        assert!(stages.iter().all(|(name, seconds)| *name == "double" && *seconds >= 0.0), "{stages:?}");
        assert!(device.settle().unwrap().is_empty());
    }
}

/// Runs of more bytes than one command takes, whose last piece is shorter.
#[test]
fn long_copies_and_clears_are_whole() {
    for Bench { device, .. } in benches().take(1) {
        let rows: Vec<u32> = (1..9_000_008).collect();
        let (from, to) = (Buffer::of(device, "from", &rows).unwrap(), Buffer::of(device, "to", &rows).unwrap());
        let mut commands = Commands::new();
        commands.stage("clear, copy");
        commands.clear(&to);
        commands.copy(&from, &to, rows.len() - 3);
        commands.clear(&from);
        assert!(commands.submit(device).unwrap().n_submissions() > 3, "each of the pieces is a command");
        let end = rows.len() - 3;
        let found = to.read(device, rows.len()).unwrap();
        assert!(found[..end] == rows[..end] && found[end..] == [0; 3]);
        assert!(from.read(device, rows.len()).unwrap().iter().all(|x| *x == 0));
    }
}

#[test]
fn a_dispatch_takes_its_workgroups_from_the_device() {
    for Bench { device, kernels } in benches() {
        let double = kernels.get(device, "double", DOUBLE, &[]).unwrap();
        let values = Buffer::of(device, "values", &[1u32; 1000]).unwrap();
        let args = Buffer::of(device, "args", &[[0, 1, 1, 0], [2, 1, 1, 0u32]]).unwrap();
        let mut commands = Commands::new();
        commands.dispatch(device, &double, &[values.bind()], &[5], Work::Indirect(&args, 0));
        commands.dispatch(device, &double, &[values.bind()], &[3], Work::Indirect(&args, 1));
        commands.submit(device).unwrap();
        let found = values.read(device, 1000).unwrap();
        assert!(found[..128].iter().all(|x| *x == 3) && found[128..].iter().all(|x| *x == 1));
    }
}

#[test]
#[should_panic(expected = "kernel `double`")]
fn rows_of_another_width_than_the_kernel_reads_are_refused() {
    let Some(Bench { device, kernels }) = benches().next() else { panic!("kernel `double` has no device") };
    let double = kernels.get(device, "double", DOUBLE, &[]).unwrap();
    let pairs = Buffer::<[u32; 2]>::zeros(device, "pairs", 4).unwrap();
    Commands::new().dispatch(device, &double, &[pairs.bind()], &[2], Work::Groups(1));
}

#[test]
fn rows_come_back_without_waiting() {
    for Bench { device, .. } in benches() {
        let buffer = Buffer::of(device, "rows", &[1u32, 2, 3]).unwrap();
        let mut on_the_way = buffer.read_back(device, 3).unwrap();
        let started = std::time::Instant::now();
        let rows = loop {
            match on_the_way.poll(device).unwrap() {
                Ok(rows) => break rows,
                Err(later) => on_the_way = later,
            }
            assert!(started.elapsed().as_secs() < 60);
        };
        assert_eq!(rows, [1, 2, 3]);
        assert_eq!(Count::of(device, 5).unwrap().read(device).unwrap(), 5);
    }
}
