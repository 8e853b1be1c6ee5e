string pick(float x) { if (x > 0.5) return "a"; return "b"; }
surface t() { Ci = pick(1) == "a" ? 1 : 0; }
