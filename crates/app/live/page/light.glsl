// Light, shadow, haze: the same for everything. Linear colors; z is up.
uniform vec3 uEye;
uniform vec3 uSun;        // direction to the sun
uniform vec3 uSunColor;
uniform vec3 uSkyColor;   // light from above
uniform vec3 uBounce;     // light from the ground
uniform vec3 uHaze;       // color of the distance
uniform highp sampler2DShadow uShadow;
uniform mat4 uShadowFrom;

float sunlit(vec3 p, vec3 n) {
    vec4 q = uShadowFrom * vec4(p + n * 0.02, 1.0);
    vec3 s = q.xyz * 0.5 + 0.5;
    if (any(lessThan(s, vec3(0.0))) || any(greaterThan(s, vec3(1.0)))) return 1.0;
    float texel = 1.0 / 2048.0;
    float sum = 0.0;
    for (int i = -1; i <= 1; i++)
        for (int j = -1; j <= 1; j++)
            sum += texture(uShadow, vec3(s.xy + vec2(float(i), float(j)) * 1.2 * texel, s.z - 0.0006));
    // Fades out at the border of the shadow map.
    vec2 edge = smoothstep(vec2(0.0), vec2(0.06), s.xy) * smoothstep(vec2(0.0), vec2(0.06), 1.0 - s.xy);
    return mix(1.0, sum / 9.0, edge.x * edge.y);
}

vec3 shade(vec3 albedo, float rough, float gloss, vec3 n, vec3 p) {
    vec3 v = normalize(uEye - p);
    vec3 h = normalize(v + uSun);
    float diffuse = max(dot(n, uSun), 0.0);
    float lit = diffuse > 0.0 ? sunlit(p, n) : 0.0;
    vec3 ambient = mix(uBounce, uSkyColor, 0.5 + 0.5 * n.z);
    // Little sky is seen close to the ground.
    ambient *= mix(0.62, 1.0, smoothstep(0.0, 0.35, p.z + 0.25 * max(n.z, 0.0)));
    float a = rough * rough;
    float nh = max(dot(n, h), 0.0);
    float d = nh * nh * (a * a - 1.0) + 1.0;
    float spec = a * a / (3.14 * d * d) * 0.25;
    float fresnel = pow(clamp(1.0 - dot(n, v), 0.0, 1.0), 4.0);
    vec3 c = albedo * (ambient + uSunColor * diffuse * lit);
    c += gloss * (uSunColor * lit * diffuse * spec + uSkyColor * (0.06 + 0.5 * fresnel));
    return c;
}

vec3 hazed(vec3 c, vec3 p) {
    float far = length(p - uEye);
    return mix(c, uHaze, 1.0 - exp(-pow(far / 34.0, 2.0)));
}

vec3 screen(vec3 c) {
    c = c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14);
    return pow(clamp(c, 0.0, 1.0), vec3(1.0 / 2.2));
}
