// The velocities that impulses give a body, v_free + M⁻¹ D γ, from the columns of `body_impulse` or `body_spin`, which the kernel imports, and of
// `free`, and where inertia is not isotropic from `mass` and `orientation`.
#import inertia

fn response_of(body: u32) -> Body {
    let sum = impulse_on(body);
    var own = free[body];
    own.v += sum.linear * own.inv_mass;
    own.w += turned_by(body, own, sum.angular);
    return own;
}
