// A box with round edges, a sphere, a capsule, or an arrow's tip, as one mesh that is stretched for each part.
layout(location = 0) in vec3 aCorner;
layout(location = 1) in vec3 aOffset;
layout(location = 2) in vec3 aNormal;
layout(location = 3) in vec4 iQuat;   // w, x, y, z
layout(location = 4) in vec3 iPos;
layout(location = 5) in vec4 iHalf;   // half extents, radius of the edges
layout(location = 6) in vec4 iColor;  // color; 0 plain, 1 ball, 2 head, 3 shining, 4 matt
uniform mat4 uClip;
out vec3 vPos;
out vec3 vNormal;
out vec3 vLocal;
flat out vec4 vColor;

vec3 rotate(vec4 q, vec3 v) {
    return v + 2.0 * cross(q.yzw, cross(q.yzw, v) + q.x * v);
}

void main() {
    vec3 local = aCorner * (iHalf.xyz - iHalf.w) + aOffset * iHalf.w;
    vPos = iPos + rotate(iQuat, local);
    vNormal = rotate(iQuat, aNormal);
    vLocal = aNormal;
    vColor = iColor;
    gl_Position = uClip * vec4(vPos, 1.0);
}
