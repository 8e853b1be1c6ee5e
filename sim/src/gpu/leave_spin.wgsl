// Leave what the impulse of a contact turns its bodies by, in the column `spin` of the kernel.
#import spin

fn leave_spin(k: u32, row: Row, z: vec3<f32>) {
    spin[k] = vec4(cross(z, row.normal), row.reach.x);
}
