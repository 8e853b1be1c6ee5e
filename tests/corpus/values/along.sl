displacement along() { P += 0.2 * normalize(Ng); N = calculatenormal(P); }
