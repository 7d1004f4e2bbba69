// The two meshes that everything solid is made of. A vertex: which corner of the box it belongs to, its offset from that corner in
// radii, its normal.

// A sphere whose octants can be pulled apart: a box with round edges, a capsule.
export function roundBox(n) {
  const vertices = [];
  const indices = [];
  // Both halves of an axis end at 0, so that the middle is stretched.
  const line = [];
  for (let i = 0; i <= n; i++) line.push([-1 + i / n, -1]);
  for (let i = 0; i <= n; i++) line.push([i / n, 1]);
  for (let axis = 0; axis < 3; axis++)
    for (const side of [-1, 1]) {
      const first = vertices.length / 9;
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
      for (const [a, signA] of line)
        for (const [b, signB] of line) {
          const p = [0, 0, 0];
          const corner = [0, 0, 0];
          p[axis] = side;
          // Equal angles rather than equal lengths: even triangles.
          p[u] = Math.tan((a * Math.PI) / 4);
          p[v] = Math.tan((b * Math.PI) / 4);
          corner[axis] = side;
          corner[u] = signA;
          corner[v] = signB;
          const length = Math.hypot(...p);
          const normal = p.map((x) => x / length);
          vertices.push(...corner, ...normal, ...normal);
        }
      const width = line.length;
      for (let i = 0; i + 1 < width; i++)
        for (let j = 0; j + 1 < width; j++) {
          const [a, b, c, d] = [first + i * width + j, first + i * width + j + 1, first + (i + 1) * width + j, first + (i + 1) * width + j + 1];
          if (side > 0) indices.push(a, c, b, b, c, d);
          else indices.push(a, b, c, b, d, c);
        }
    }
  return { vertices: new Float32Array(vertices), indices: new Uint16Array(indices) };
}

// An arrow's tip along x: two radii long.
export function cone(n) {
  const vertices = [];
  const indices = [];
  const slope = [1 / Math.sqrt(5), 2 / Math.sqrt(5)];
  for (let i = 0; i <= n; i++) {
    const angle = (2 * Math.PI * i) / n;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    vertices.push(0, 0, 0, 0, c, s, slope[0], slope[1] * c, slope[1] * s);
    vertices.push(0, 0, 0, 2, 0, 0, slope[0], slope[1] * c, slope[1] * s);
    vertices.push(0, 0, 0, 0, c, s, -1, 0, 0);
    vertices.push(0, 0, 0, 0, 0, 0, -1, 0, 0);
    if (i === n) break;
    const a = 4 * i;
    indices.push(a, a + 4, a + 1, a + 2, a + 3, a + 6);
  }
  return { vertices: new Float32Array(vertices), indices: new Uint16Array(indices) };
}
