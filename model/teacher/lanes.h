// Body of the function that solves one group of vertices of a colour (`lanes.py`), a vertex a lane. World space, SI.
// Forces and Hessians are those of newton 1.8: stable Neo-Hookean triangles (Smith et al. 2018, for shells) and hinges
// after Grinspun et al. 2003, as in `hinges.py`, both without damping, and contacts with a body that does not move.
typedef float lanes __attribute__((ext_vector_type(16)));
typedef int whole __attribute__((ext_vector_type(16)));
constexpr int width = 16;
constexpr float least = 1e-6f;  // m or m2, lengths and areas below which a hinge has no angle

struct vec {
    lanes x, y, z;
    vec operator+(vec o) const { return {x + o.x, y + o.y, z + o.z}; }
    vec operator-(vec o) const { return {x - o.x, y - o.y, z - o.z}; }
    vec operator*(lanes s) const { return {x * s, y * s, z * s}; }
};
struct symmetric {
    lanes xx, xy, xz, yy, yz, zz;
};

auto dot = [](vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
auto cross = [](vec a, vec b) -> vec {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
};
auto root = [](lanes v) { return __builtin_elementwise_sqrt(v); };
auto larger = [](lanes a, lanes b) { return __builtin_elementwise_max(a, b); };
auto chosen = [](whole where, lanes a, lanes b) -> lanes { return where ? a : b; };
auto row = [](const wp::array_t<float> &table, int k) {
    lanes out;
    __builtin_memcpy(&out, table.data + width * k, sizeof out);  // which nothing aligns
    return out;
};
auto corner = [&](const wp::array_t<int> &table, int k) {
    vec out;
    for (int l = 0; l < width; ++l) {
        const wp::vec3 &p = positions.data[table.data[width * k + l]];
        out.x[l] = p[0], out.y[l] = p[1], out.z[l] = p[2];
    }
    return out;
};
// Angle of (x, y), rad, by a Chebyshev fit of atan on [0, 1], 2e-8 off.
auto angle = [&](lanes y, lanes x) {
    lanes ax = __builtin_elementwise_abs(x), ay = __builtin_elementwise_abs(y);
    lanes r = __builtin_elementwise_min(ax, ay) / larger(larger(ax, ay), lanes(1e-30f)), s = r * r;
    lanes p = 0.00283406429f;
    p = p * s - 0.0160050305f, p = p * s + 0.0425876074f, p = p * s - 0.0749544544f, p = p * s + 0.106367541f;
    p = p * s - 0.142025705f, p = p * s + 0.199924836f, p = p * s - 0.333330668f, p = p * s + 0.999999984f;
    r *= p;
    r = chosen(ay > ax, 1.57079633f - r, r);
    r = chosen(x < 0.0f, 3.14159265f - r, r);
    return chosen(y < 0.0f, -r, r);
};

vec force{lanes(0.0f), lanes(0.0f), lanes(0.0f)};
symmetric hessian{lanes(0.0f), lanes(0.0f), lanes(0.0f), lanes(0.0f), lanes(0.0f), lanes(0.0f)};
auto add_outer = [&](vec v, lanes s) {
    vec w = v * s;
    hessian.xx += w.x * v.x, hessian.xy += w.x * v.y, hessian.xz += w.x * v.z;
    hessian.yy += w.y * v.y, hessian.yz += w.y * v.z, hessian.zz += w.z * v.z;
};
auto add_diagonal = [&](lanes s) { hessian.xx += s, hessian.yy += s, hessian.zz += s; };

const int *own = cloth.vertices.data + width * group;
const vec at = corner(cloth.vertices, group);

// What other cloth presses on it with, and its inertia.
lanes heavy;
vec aim;
for (int l = 0; l < width; ++l) {
    const int v = own[l];
    const wp::vec3 &f = forces.data[v], &i = inertia.data[v];
    const wp::mat33 &h = hessians.data[v];
    force.x[l] = f[0], force.y[l] = f[1], force.z[l] = f[2];
    hessian.xx[l] = h.data[0][0], hessian.xy[l] = h.data[0][1], hessian.xz[l] = h.data[0][2];
    hessian.yy[l] = h.data[1][1], hessian.yz[l] = h.data[1][2], hessian.zz[l] = h.data[2][2];
    aim.x[l] = i[0], aim.y[l] = i[1], aim.z[l] = i[2];
    heavy[l] = mass.data[v];
}
const lanes per_step = heavy * (1.0f / (dt * dt));
force = force + (aim - at) * per_step;
add_diagonal(per_step);

// The skin: a penalty, damped on the way in, and friction that is linear up to the speed of slip.
lanes deep, stiffness;
vec out, moved;
for (int l = 0; l < width; ++l) {
    const int v = own[l], node = skin.first.data[v];
    deep[l] = stiffness[l] = out.x[l] = out.y[l] = out.z[l] = moved.x[l] = moved.y[l] = moved.z[l] = 0.0f;
    if (node < 0) continue;
    const int contact = node / 3;
    const wp::vec3 &n = skin.normals.data[contact], &p = skin.points.data[contact], &b = before.data[v];
    out.x[l] = n[0], out.y[l] = n[1], out.z[l] = n[2];
    deep[l] = skin.radius.data[v] + n[0] * (p[0] - at.x[l]) + n[1] * (p[1] - at.y[l]) + n[2] * (p[2] - at.z[l]);
    stiffness[l] = skin.stiffness.data[contact];
    moved.x[l] = at.x[l] - b[0], moved.y[l] = at.y[l] - b[1], moved.z[l] = at.z[l] - b[2];
}
const lanes load = stiffness * larger(deep, lanes(0.0f)), along = dot(out, moved);
const vec slid = moved - out * along;
const lanes far = root(dot(slid, slid)), start = skin.slip * dt;
const lanes rate = chosen(far > start, 1.0f / far, (2.0f - far / start) / start);
const lanes grip = skin.friction * load * chosen(far > 0.0f, rate, lanes(0.0f));
const lanes drag = chosen((deep > 0.0f) & (along < 0.0f), lanes(skin.damping / dt), lanes(0.0f));
force = force + out * (load - drag * along) - slid * grip;
add_outer(out, chosen(deep > 0.0f, stiffness, lanes(0.0f)) + drag - grip);
add_diagonal(grip);

// Triangles, from the vertex on.
const float stiff = lame + lame, alpha = 1.0f + lame / stiff;
for (int k = cloth.first_triangle.data[group]; k < cloth.first_triangle.data[group + 1]; ++k) {
    const vec x01 = corner(cloth.triangles, 2 * k) - at, x02 = corner(cloth.triangles, 2 * k + 1) - at;
    const lanes d00 = row(cloth.shapes, 5 * k), d01 = row(cloth.shapes, 5 * k + 1), d10 = row(cloth.shapes, 5 * k + 2),
                d11 = row(cloth.shapes, 5 * k + 3), area = row(cloth.shapes, 5 * k + 4);
    const vec f0 = x01 * d00 + x02 * d10, f1 = x01 * d01 + x02 * d11, turned = cross(f0, f1);
    const lanes ratio = root(larger(dot(turned, turned), lanes(1e-20f))), inverse = 1.0f / ratio;
    const vec normal = turned * inverse, g0 = cross(f1, normal), g1 = cross(normal, f0);
    const lanes s = stiff * (ratio - alpha), a0 = -(d00 + d10), a1 = -(d01 + d11);
    force = force - ((f0 * lame + g0 * s) * a0 + (f1 * lame + g1 * s) * a1) * area;
    const lanes r = larger(s, lanes(0.0f)) * inverse;
    const vec slope = g0 * a0 + g1 * a1, w = f1 * a0 - f0 * a1;
    add_outer(slope, (stiff - r) * area);
    add_outer(w, -r * area);
    add_diagonal((lame * (a0 * a0 + a1 * a1) + r * dot(w, w)) * area);
}

// Hinges x0 and x1 beside an edge from x2 to x3; the vertex is x0 of the first ones, x2 of the others.
auto bend = [&](vec x0, vec x1, vec x2, vec x3, bool at_end, lanes stiffness, lanes rest) {
    const vec e = x3 - x2, n0 = cross(x2 - x0, x3 - x0), n1 = cross(x3 - x1, x2 - x1);
    const lanes ee = dot(e, e), nn0 = dot(n0, n0), nn1 = dot(n1, n1), length = root(ee);
    const lanes change = angle(dot(cross(n0, n1), e) / length, dot(n0, n1)) - rest;
    vec slope = n0 * (-length / nn0);
    if (at_end) {
        const vec other = n1 * (-length / nn1);
        slope = slope * (dot(x0 - x2, e) / ee - 1.0f) + other * (dot(x1 - x2, e) / ee - 1.0f);
    }
    const whole flat = (ee < least * least) | (nn0 < least * least) | (nn1 < least * least);
    slope = {chosen(flat, lanes(0.0f), slope.x), chosen(flat, lanes(0.0f), slope.y), chosen(flat, lanes(0.0f), slope.z)};
    force = force - slope * chosen(flat, lanes(0.0f), stiffness * change);
    add_outer(slope, stiffness);
};
for (int k = cloth.first_tip.data[group]; k < cloth.first_tip.data[group + 1]; ++k)
    bend(at, corner(cloth.tips, 3 * k), corner(cloth.tips, 3 * k + 1), corner(cloth.tips, 3 * k + 2), false,
         row(cloth.tip_bends, 2 * k), row(cloth.tip_bends, 2 * k + 1));
for (int k = cloth.first_end.data[group]; k < cloth.first_end.data[group + 1]; ++k)
    bend(corner(cloth.ends, 3 * k), corner(cloth.ends, 3 * k + 1), at, corner(cloth.ends, 3 * k + 2), true,
         row(cloth.end_bends, 2 * k), row(cloth.end_bends, 2 * k + 1));

// Cramer's rule.
const symmetric &h = hessian;
const lanes c0 = h.yy * h.zz - h.yz * h.yz, c1 = h.xz * h.yz - h.xy * h.zz, c2 = h.xy * h.yz - h.xz * h.yy;
const lanes determinant = h.xx * c0 + h.xy * c1 + h.xz * c2;
const lanes over = chosen(__builtin_elementwise_abs(determinant) > 1e-8f, 1.0f / determinant, lanes(0.0f));
const lanes c3 = h.xx * h.zz - h.xz * h.xz, c4 = h.xy * h.xz - h.xx * h.yz, c5 = h.xx * h.yy - h.xy * h.xy;
const vec step = {(c0 * force.x + c1 * force.y + c2 * force.z) * over,
                  (c1 * force.x + c3 * force.y + c4 * force.z) * over,
                  (c2 * force.x + c4 * force.y + c5 * force.z) * over};
for (int l = 0; l < cloth.sizes.data[group]; ++l) {
    wp::vec3 &d = displacements.data[own[l]];
    d[0] += step.x[l], d[1] += step.y[l], d[2] += step.z[l];
}
