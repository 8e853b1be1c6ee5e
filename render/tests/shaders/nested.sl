// Lights within lights, and the globals.
surface nested() { normal n = faceforward(normalize(N),I); color outer = 0, inner = 0;
  illuminance(P, n, PI/2) { vector l1 = normalize(L); color c1 = Cl; illuminance(P, n, PI/3) {
  inner += .1*Cl*max(0, l1.normalize(L)); } outer += c1*max(0,n.l1); }
  Ci = .5*outer + inner + .1*color(u,v,0) + .05*color(s,t,0) + .02*time + 3*du*0 + .05*length(dPdu)
  + .05*length(dPdv) + .02*length(E-P) + .1*specular(n,-normalize(I),.2)+.1*phong(n,-normalize(I),8); Oi = Os;
  Ci *= Oi; if (ncomps == 3) Ci *= .9; }
