// What the displacement shader, the attributes and the options say.
surface labels() { float h = 0; float km = 0; displacement("Km", km); float sr[1]; float q = 0;
  attribute("user:q", q); float fr = 0; option("Frame", fr); string sn = ""; attribute("identifier:name", sn);
  Ci = .3 + .3*km + .4*q; if (sn == "ball") Ci *= color(1,.6,.4); normal n = faceforward(normalize(N),I);
  Ci *= diffuse(n) + .2; Oi = 1; float dpt = 0; rayinfo("depth", dpt); Ci += dpt; }
