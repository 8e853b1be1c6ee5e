// The column `spin` of a kernel (2 n_contacts): what an impulse turns A and B by.

fn with_arm(row: Row, z: vec3<f32>) -> vec4<f32> {
    return vec4(z, 0.0);
}

// Of a side of a contact with the impulse z: twice the contact, and one more for B.
fn spin_on(side: u32, z: vec4<f32>) -> vec3<f32> {
    return spin[side].xyz;
}
