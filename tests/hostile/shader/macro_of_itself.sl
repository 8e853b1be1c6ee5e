#define F(x) F(x) F(x)
surface macro_of_itself() { Ci = F(F(F(1))); }