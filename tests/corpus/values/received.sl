surface received() { color sum = 0; illuminance(P, N, PI) { sum += Cl; } Oi = 1; Ci = sum; }
