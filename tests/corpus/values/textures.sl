surface textures() {
    float channels = 0, there = 0, lost = 1;
    string type = "", made = "";
    textureinfo("ramp.png", "channels", channels);
    textureinfo("ramp.png", "exists", there);
    textureinfo("none.png", "exists", lost);
    textureinfo("ramp.png", "type", type);
    textureinfo("env", "type", made);
    Oi = 1;
    Ci = color(channels * there, type == "texture" && made == "environment" ? 0.5 : 0, lost);
}
