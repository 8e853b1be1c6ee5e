// Strings that choose: parameters, arrays, joined and matched.
surface patterns(string mode = "stripes"; string space = "object"; string names[2] = {"a","b"}; float k = 1;) {
  string m = mode; color c = .5; string full = concat(mode, "_", names[1]);
  if (m == "stripes") c = mod(floor(s*8),2); else if (m == "rings") c = mod(floor(8*length(transform(space,P))),2);
  else if (match("ch.*", m)) c = mod(floor(s*8)+floor(t*8),2);
  if (full == "rings_b") c *= color(1,.5,.5);
  if (names[0] != "a") c *= .5;
  Ci = c*Cs*k; Oi = 1;
}
