//! The layout of rows in Rust against that in WGSL, by reflection.

use gpu::layout::check;

gpu::wgsl_rows! {
    /// Two fields that fit.
    struct Sphere {
        /// A centre.
        centre: [i32; 3],
        /// A radius.
        radius: f32,
    }

    /// A vector of three and more, which WGSL pads.
    struct Padded {
        /// A vector.
        normal: [f32; 3],
        /// Two numbers.
        bodies: [u32; 2],
    }
}

#[test]
fn rows_with_the_same_offsets_pass() {
    check::<Sphere>("struct Sphere { centre: vec3<i32>, radius: f32 }").unwrap();
}

#[test]
fn another_offset_size_order_or_name_is_found() {
    for text in [
        "struct Sphere { radius: f32, centre: vec3<i32> }",
        "struct Sphere { centre: vec3<i32>, radius: vec2<f32> }",
        "struct Sphere { centre: vec3<i32>, r: f32 }",
        "struct Sphere { centre: vec3<i32> }",
        "struct Ball { centre: vec3<i32>, radius: f32 }",
        "alias Sphere = u32;",
        "struct Sphere {",
    ] {
        check::<Sphere>(text).unwrap_err();
    }
    // 12 + 8 bytes in Rust; WGSL aligns the pair to 16, and the whole to 32.
    let error = check::<Padded>("struct Padded { normal: vec3<f32>, bodies: vec2<u32> }").unwrap_err();
    assert!(error.contains("(\"bodies\", 16)") && error.contains("(\"(end)\", 32)"), "{error}");
}
