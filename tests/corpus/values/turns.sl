displacement turns() { N = normal(1, 0, 0); }
