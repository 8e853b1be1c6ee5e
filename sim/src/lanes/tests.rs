//! Lanes in registers against arrays, bit for bit.

use super::*;
use std::arch::x86_64::{__m256, __m256d, __m512};

/// The projection of a contact without friction has no negative normal part and no tangent part.
#[test]
fn without_friction_nothing_pulls() {
    let n = Lane3 { x: Plain([0.0f64; 4]), y: Plain([0.0; 4]), z: Plain([1.0; 4]) };
    let y = Lane3 { x: Plain([0.0, 0.0, 2.0, 2.0]), y: Plain([0.0; 4]), z: Plain([-3.0, 3.0, -3.0, 3.0]) };
    let z = project(y, n, Plain([0.0; 4]));
    assert_eq!(z.z.0, [0.0, 3.0, 0.0, 3.0]);
    assert_eq!(z.x.0, [0.0; 4]);
}

/// Registers load, compute and store the same bits as arrays, be there 16 of them or 32.
#[test]
fn registers_and_arrays_agree() {
    #[target_feature(enable = "avx2")]
    unsafe fn wide(v: &[DVec3; 4], t: [&Twist; 4], f: &[[f32; 8]; 8], out: &mut Out) -> [[f32; 8]; 8] {
        double::<Wide<__m256d>>(v, t, out);
        single::<Wide<__m256>>(f)
    }
    #[target_feature(enable = "avx512f,avx512vl")]
    unsafe fn many(v: &[DVec3; 4], t: [&Twist; 4], f: &[[f32; 8]; 8], out: &mut Out) -> [[f32; 8]; 8] {
        double::<Wide<__m256d>>(v, t, out);
        single::<Wide<__m256>>(f)
    }
    /// Vectors, twists and a mask.
    type Out = ([DVec3; 4], [Twist; 4], u32);
    fn double<V: Lanes4>(v: &[DVec3; 4], t: [&Twist; 4], out: &mut Out) {
        let n = V::load3(v);
        let [lin, ang] = V::twists(t);
        let [a, b] = V::load2(&[[0.1, 0.2], [1.0, -3.0], [0.5, 0.25], [7.0, 9.0]]);
        let n = n.times(V::splat(1.0) / n.dot(n).sqrt());
        let columns = V::columns(&[[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]; 4]);
        let row = V::load(&V::rows(columns)[2][..4].try_into().unwrap());
        V::store3(project(lin.cross(ang).times(a).plus(lin.times(row)), n, b * b), &mut out.0);
        (out.1, out.2) = (V::to_twists(ang, lin.cross(n)), lin.x.mask_le(ang.y));
    }
    fn single<V: Lanes<f32, 8>>(f: &[[f32; 8]; 8]) -> [[f32; 8]; 8] {
        let mut c = V::columns(f);
        c[0] = c[0] * c[1] / c[2];
        c[1] = c[3].select_le(c[4], c[5], c[6]).sqrt() - c[7];
        V::rows(c)
    }
    if !std::arch::is_x86_feature_detected!("avx2") {
        eprintln!("skipped: this processor has no AVX2");
        return;
    }
    let number = |i: usize| ((i * 7919) % 101) as f64 * 0.173 - 4.0;
    let vector = |i: usize| DVec3::new(number(i), number(i + 1), number(i + 2));
    let v: [DVec3; 4] = std::array::from_fn(|i| vector(3 * i));
    let t: [Twist; 4] = std::array::from_fn(|i| Twist { v: vector(50 + 6 * i), w: vector(53 + 6 * i) });
    let f = std::array::from_fn(|i| std::array::from_fn(|k| number(8 * i + k).abs() as f32 + 0.5));
    let t = [&t[0], &t[1], &t[2], &t[3]];
    let (mut a, mut b): (Out, Out) = Default::default();
    // SAFETY: the processor has AVX2.
    let single_wide = unsafe { wide(&v, t, &f, &mut a) };
    double::<Plain<f64, 4>>(&v, t, &mut b);
    assert_eq!(a, b);
    assert_eq!(single_wide, single::<Plain<f32, 8>>(&f));
    if has_avx512() {
        let mut c = Out::default();
        // SAFETY: the processor has AVX-512.
        let single_many = unsafe { many(&v, t, &f, &mut c) };
        assert_eq!((c, single_many), (b, single_wide));
    }
    assert!(a.0.iter().all(|v| v.is_finite()) && a.0 != [DVec3::ZERO; 4] && a.2 != 0 && a.2 != 15);
}

/// Sixteen lanes have the same bits in one register, in two, and in arrays.
#[test]
fn sixteen_lanes_agree() {
    type Rows = [[f32; 8]; 16];
    fn sixteen<V: Lanes<f32, 16>>(f: &Rows) -> Rows {
        let mut c = V::columns(f);
        c[0] = V::load(&(c[0] * c[1] / c[2]).to_array()) + V::splat(0.3);
        c[1] = c[3].select_le(c[4], c[5], c[6]).sqrt() - c[7];
        (c[2], c[3]) = cone(c[1], c[4], c[5]);
        V::rows(c)
    }
    #[target_feature(enable = "avx2")]
    unsafe fn two(f: &Rows) -> Rows {
        sixteen::<Double<Wide<__m256>>>(f)
    }
    #[target_feature(enable = "avx512f,avx512vl")]
    unsafe fn one(f: &Rows) -> Rows {
        sixteen::<Wide<__m512>>(f)
    }
    let number = |i: usize| ((i * 7919) % 101) as f32 * 0.173 + 0.5;
    let f: Rows = std::array::from_fn(|i| std::array::from_fn(|k| number(8 * i + k)));
    let plain = sixteen::<Plain<f32, 16>>(&f);
    assert!(plain.as_flattened().iter().all(|x| x.is_finite()) && plain != f);
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        assert_eq!(unsafe { two(&f) }, plain);
    }
    if has_avx512() {
        // SAFETY: the processor has AVX-512.
        assert_eq!(unsafe { one(&f) }, plain);
    }
}
