// The column `spin` of a kernel (n_contacts): what an impulse turns the bodies by, where arms lie along the normal n. It is z × n and the length
// of the arm on A; that on B is the fourth number of the impulse z.

fn with_arm(row: Row, z: vec3<f32>) -> vec4<f32> {
    return vec4(z, row.reach.y);
}

// Of a side of a contact with the impulse z: twice the contact, and one more for B.
fn spin_on(side: u32, z: vec4<f32>) -> vec3<f32> {
    let own = spin[side / 2u];
    return own.xyz * select(own.w, z.w, (side & 1u) == 1u);
}
