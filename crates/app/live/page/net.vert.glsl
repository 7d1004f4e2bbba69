layout(location = 0) in vec3 aPlace;  // in the goal's axes
layout(location = 1) in vec2 aThread; // along and across the net [m]
uniform mat4 uClip;
uniform vec3 uGoal;
out vec3 vPos;
out vec2 vThread;
void main() {
    float c = cos(uGoal.z), s = sin(uGoal.z);
    vPos = vec3(uGoal.xy + vec2(c * aPlace.x - s * aPlace.y, s * aPlace.x + c * aPlace.y), aPlace.z);
    vThread = aThread;
    gl_Position = uClip * vec4(vPos, 1.0);
}
