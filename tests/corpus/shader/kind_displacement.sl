displacement d(float Km = 0.1;) { P += Km * noise(P * 4) * normalize(N); N = calculatenormal(P); }
