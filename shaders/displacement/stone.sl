// A broken stone, cut from a sphere by planes that differ from stone to stone (id): it stays within the sphere, and turns with it. depth:
// of the deepest cut, in radii; rounding: how much edges are worn, 0 sharp to 0.5 a pebble; slab: 0 as deep everywhere, 1 flat along the
// stone's own z; grain: height of the grain, in radii.
displacement stone(float depth = 0.3; float rounding = 0.06; float slab = 0; float grain = 0.04; uniform float id = 0;) {
    // Fifteen directions, evenly spread, which each stone has turned its own way.
    uniform float z[15] = {0.93, 0.8, 0.67, 0.53, 0.4, 0.27, 0.13, 0, -0.13, -0.27, -0.4, -0.53, -0.67, -0.8, -0.93};
    point Q = transform("object", P);
    float R = length(Q);
    vector d = vector(Q) / R;
    uniform float first = 2 * PI * mod(id * 0.618034, 1), lean = PI * mod(id * 0.754878, 1);
    uniform vector a = vector(cos(first), sin(first), 0), c = vector(-sin(first) * sin(lean), cos(first) * sin(lean), cos(lean));
    uniform vector b = c ^ a;
    float x = d . a, y = d . b, h = d . c;
    // How far out of the nearest plane a direction points: 1 where a plane goes through the sphere.
    float most = 1;
    uniform float i;
    for (i = 0; i < 15; i += 1) {
        uniform float turn = 2.399963 * i;
        uniform float r = sqrt(1 - z[i] * z[i]);
        uniform float far = 1 - depth * (0.3 + 0.7 * mod((id + 3.7) * (0.5698403 + 0.414214 * i), 1)) * (1 + slab * z[i] * z[i]);
        float out = (x * (r * cos(turn)) + y * (r * sin(turn)) + h * z[i]) / max(0.2, far);
        float near = max(0, rounding - abs(most - out)) / max(rounding, 0.001);
        most = max(most, out) + 0.25 * rounding * near * near;
    }
    float rough = 0;
    if (grain > 0) {
        uniform vector shift = 17 * vector(mod(id * 0.31, 1), mod(id * 0.47, 1), mod(id * 0.73, 1));
        rough = grain * (noise(5 * d + shift) + 0.5 * noise(13 * d + shift));
    }
    P = transform("object", "current", point(d * (R * clamp(min(1, 1 / most) - rough, 0.3, 1))));
    N = calculatenormal(P);
}
