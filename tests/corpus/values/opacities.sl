surface opacities() { color sum = 0; illuminance(P, N, PI) { sum += Ol; } Oi = 1; Ci = sum; }
