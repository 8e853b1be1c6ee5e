// A lamp in a cone, with a picture of its own.
light gobo(point from = point "shader" (-2,2,-3); point to = point "shader"(0,0,0); float cone = .5;) {
  uniform vector A = (to - from)/length(to-from);
  illuminate(from, A, cone) { float c = (L.A)/length(L); Cl = 30*pow(c, 8)/(L.L) * (1 - .5*cellnoise(5*Ps));
    color gob = color "hsv" (mod(atan(ycomp(L),xcomp(L))/PI/2, 1), .5, 1); Cl *= gob; }
}
