// Leave what the impulse of a contact turns its bodies by, in the column `spin` of the kernel.
#import spin

fn leave_spin(k: u32, row: Row, z: vec3<f32>) {
    spin[2u * k] = vec4(torque_of(row, z, false), 0.0);
    spin[2u * k + 1u] = vec4(torque_of(row, z, true), 0.0);
}
