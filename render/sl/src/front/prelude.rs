//! Shading functions that are written in the language itself.

/// Shading functions as the specification defines them (RISpec 15.6), inlined where they are called.
pub const PRELUDE: &str = "
color diffuse(normal axis) {
    color sum = 0;
    illuminance (P, axis, 1.5707963) {
        uniform float off = 0;
        lightsource(\"__nondiffuse\", off);
        if (off == 0) sum += Cl * max(0, normalize(L) . axis);
    }
    return sum;
}
color specularbrdf(vector light, normal axis, vector view, float roughness) {
    vector half = normalize(light + view);
    return pow(max(0, axis . half), 1 / max(roughness, 0.0001));
}
color specular(normal axis, vector view, float roughness) {
    color sum = 0;
    illuminance (P, axis, 1.5707963) {
        uniform float off = 0;
        lightsource(\"__nonspecular\", off);
        if (off == 0) sum += Cl * specularbrdf(normalize(L), axis, view, roughness);
    }
    return sum;
}
color phong(normal axis, vector view, float size) {
    color sum = 0;
    vector mirrored = reflect(-view, axis);
    illuminance (P, axis, 1.5707963) { sum += Cl * pow(max(0, mirrored . normalize(L)), size); }
    return sum;
}
float depth(point p) {
    uniform float clip[2] = {0, 1};
    option(\"Clipping\", clip);
    return (zcomp(transform(\"camera\", p)) - clip[0]) / (clip[1] - clip[0]);
}
float distance(point a, point b) { return length(a - b); }
float ptlined(point a, point b, point q) {
    vector way = b - a;
    float length2 = way . way;
    float t = length2 > 0 ? clamp(((q - a) . way) / length2, 0, 1) : 0;
    return length(q - (a + way * t));
}
point rotate_(point q; float angle; point a, b) {
    vector axis = normalize(b - a);
    vector arm = q - a;
    float c = cos(angle);
    return a + arm * c + (axis ^ arm) * sin(angle) + axis * ((axis . arm) * (1 - c));
}
void fresnel5_(vector i; normal n; float eta; output float kr; output float kt) {
    float c = abs(i . n) / max(length(i) * length(n), 1e-8);
    float g2 = 1 / (eta * eta) - 1 + c * c;
    if (g2 < 0) {
        kr = 1;
    } else {
        float g = sqrt(g2);
        float a = (g - c) / (g + c);
        float b = (c * (g + c) - 1) / (c * (g - c) + 1);
        kr = min(1, 0.5 * a * a * (1 + b * b));
    }
    kt = 1 - kr;
}
void fresnel7_(vector i; normal n; float eta; output float kr; output float kt; output vector r; output vector t) {
    fresnel5_(i, n, eta, kr, kt);
    r = reflect(i, n);
    t = refract(i, n, eta);
}
float raylevel() {
    float depth = 0;
    rayinfo(\"depth\", depth);
    return depth;
}
float isshadowray() {
    return 0;
}
float filterstep2_(float edge, float x, float width) {
    return (x - edge) / max(width * filterwidth(x), 1e-6);
}
float filterstep3_(float edge, float a, float b, float width) {
    return (0.5 * (a + b) - edge) / max(width * abs(b - a), 1e-6);
}
float step_box_(float x) { return clamp(x + 0.5, 0, 1); }
float step_triangle_(float x) {
    float c = clamp(x, -1, 1);
    return 0.5 + c - 0.5 * c * abs(c);
}
float step_gaussian_(float x) {
    float c = min(abs(x), 1) * 1.41421356;
    float t = 1 / (1 + 0.3275911 * c);
    float rest = t * (0.254829592 + t * (t * (1.421413741 + t * (1.061405429 * t - 1.453152027)) - 0.284496736));
    return 0.5 + sign(x) * 0.5 * (1 - rest * exp(-c * c)) / 0.954499736;
}
float step_catmullrom_(float x) {
    float r = min(abs(x), 2);
    float inner = r * (1 + r * r * (0.375 * r - 0.83333333));
    float outer = r * (2 + r * (r * (0.83333333 - 0.125 * r) - 2)) - 0.16666667;
    return 0.5 + sign(x) * (r < 1 ? inner : outer);
}
";
