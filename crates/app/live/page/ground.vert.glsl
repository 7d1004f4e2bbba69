layout(location = 0) in vec2 aPlace;
uniform mat4 uClip;
uniform vec2 uMiddle;
out vec3 vPos;
void main() {
    vPos = vec3(uMiddle + aPlace * 70.0, 0.0);
    gl_Position = uClip * vec4(vPos, 1.0);
}
