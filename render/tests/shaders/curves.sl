// Splines of every basis, steps and the mathematical functions.
surface curves(float kn[6] = {0,.1,.9,.3,.7,1};) {
  float a = spline(s, 0,0,.2,.9,.4,1,1), b = spline("linear", t, 0,.5,1,.2), c = spline("bspline", s, kn),
  d = spline("bezier", t, 0,.2,.9,.4,.5,.6,.8), e = spline("catmull-rom", s, kn);
  color g = spline("linear", s, color(1,0,0), color(0,1,0), color(0,0,1), color(1,1,0));
  float m = exp(-s)+log(1+t)+log(2+s,2)+pow(s,.3)+sqrt(t)+inversesqrt(1+s)+sign(s-.5)+round(4*t)/4+ceil(3*s)/3+floor(3*t)/3+mod(s*5,1.5)+abs(sin(9*t))+tan(s)*.2+asin(t)*.3+acos(s)*.3+atan(s,t)*.2+atan(s)*.1+radians(45*s)+degrees(t)/90;
  float st = step(.4,s)+smoothstep(.2,.7,t)+filterstep(.5,s)+filterstep(.3,t,"filter","triangle");
  Ci = (color(a,b,c)+g+d+e)/4 + m/30 + st/20; Oi = 1;
}
