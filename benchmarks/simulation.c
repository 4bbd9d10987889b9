/* One joint with dry friction under a sampled controller, as one would write it in C: the same steps as
   synthesis/simulation/batch, given the same matrices. gcc -O2 -march=native -shared -fPIC */
#include <math.h>
#include <string.h>

enum { M = 8, MODES = 16, MOST = 40 };

typedef struct { double friction[2], torque, stiction; } Limits;

static int mode(const int *s) { return (s[0] == 0) + 2 * (s[1] == 0) + 4 * (s[2] != 0); }

static void linear(int n, const double *x, const double *w, const double *D, double *y) {
    for (int i = 0; i < n; i++, D += n + M) {
        double value = x[i];
        for (int j = 0; j < n; j++) value += D[j] * x[j];
        for (int j = 0; j < M; j++) value += D[n + j] * w[j];
        y[i] = value;
    }
}

static double reading(int n, const double *row, const double *x, const double *w) {
    double value = 0;
    for (int j = 0; j < n; j++) value += row[j] * x[j];
    for (int j = 0; j < M; j++) value += row[n + j] * w[j];
    return value;
}

static void advance(int n, const double *x, double *w, const double *D, const int *s, const Limits *l, double *y) {
    w[4] = -l->friction[0] * s[0];
    w[5] = -l->friction[1] * s[1];
    w[6] = s[2] ? l->torque * s[2] : 0.0;
    linear(n, x, w, D, y);
}

static int saturation(double demand, const Limits *l) { return fabs(demand) <= l->torque ? 0 : demand > 0 ? 1 : -1; }

static int holds(int n, const double *y, const double *w, const double *rows, const int *s, const Limits *l) {
    for (int c = 0; c < 2; c++)
        if (l->friction[c] > 0) {
            if (s[c] == 0) {
                if (fabs(reading(n, rows + c * (n + M), y, w)) > l->friction[c] * l->stiction) return 0;
            } else if (y[2 * c] * s[c] <= 0) return 0;
        }
    return !(l->torque < INFINITY) || saturation(reading(n, rows + 2 * (n + M), y, w), l) == s[2];
}

static void implicit(int n, const double *x, double *w, const double *steps, int levels, const double *rows, int *s,
                     const Limits *l, double *y) {
    const long per = (long)(n + M) * n, all = levels * per;
    const double *D;
    if (l->torque < INFINITY) s[2] = saturation(reading(n, rows + (mode(s) * 4 + 2) * (n + M), x, w), l);
    for (int pass = 0; pass < 3; pass++) {
        int torn = 0;
        advance(n, x, w, steps + mode(s) * all + (levels - 1) * per, s, l, y);
        for (int c = 0; c < 2; c++)
            if (s[c] == 0) {
                double f = reading(n, rows + (mode(s) * 4 + c) * (n + M), y, w);
                if (fabs(f) > l->friction[c] * l->stiction) { s[c] = f < 0 ? 1 : -1; torn = 1; }
            }
        if (!torn) break;
    }
    D = steps + mode(s) * all + (levels - 1) * per;
    for (int sweep = 0; sweep < 50; sweep++) {
        int changed = 0;
        for (int c = 0; c < 2; c++)
            if (l->friction[c] > 0 && s[c] != 0) {
                linear(n, x, w, D, y);
                double old = w[4 + c], f = old - y[2 * c] / D[2 * c * (n + M) + n + 4 + c];
                f = fmin(fmax(f, -l->friction[c]), l->friction[c]);
                changed |= fabs(f - old) > 1e-15 * l->friction[c];
                w[4 + c] = f;
            }
        if (!changed) break;
    }
    linear(n, x, w, D, y);
    for (int c = 0; c < 2; c++)
        if (l->friction[c] > 0 && s[c] != 0) {
            if (fabs(w[4 + c]) < l->friction[c]) { y[2 * c] = 0.0; s[c] = 0; }
            else s[c] = w[4 + c] < 0 ? 1 : -1;
        }
}

/* Largest |θ| of the last quarter, and the energy put in. */
void joint(int n, int levels, const double *steps, const double *rows, const double *limits, long ticks,
           const double *push, int nc, const double *A, const double *B, const double *C, const double *Dc,
           double *out) {
    const long per = (long)(n + M) * n;
    const long whole = 1L << (levels - 1);
    Limits l = {{limits[0], limits[1]}, limits[2], limits[3]};
    double x[MOST] = {0}, y[MOST], w[M] = {0}, xi[MOST] = {0}, next[MOST], energy = 0, late = 0;
    int s[3] = {l.friction[0] == 0, l.friction[1] == 0, 0};
    for (long k = 0; k < ticks; k++) {
        w[0] = push[k];
        double tau = reading(n, rows + (mode(s) * 4 + 3) * (n + M), x, w), demand = Dc[0] * tau + Dc[1] * x[1];
        for (int i = 0; i < nc; i++) {
            demand += C[i] * xi[i];
            next[i] = B[2 * i] * tau + B[2 * i + 1] * x[1];
            for (int j = 0; j < nc; j++) next[i] += A[i * nc + j] * xi[j];
        }
        memcpy(xi, next, sizeof(double) * nc);
        w[2] = demand;
        double before = x[1];
        for (long at = 0; at < whole;) {
            long span = at ? (at & -at) : whole;
            int level = 0;
            for (long size = span; size < whole; size <<= 1) level++;
            while (span > 1) {
                advance(n, x, w, steps + (mode(s) * levels + level) * per, s, &l, y);
                if (holds(n, y, w, rows + mode(s) * 4 * (n + M), s, &l)) break;
                span >>= 1;
                level++;
            }
            if (span == 1) implicit(n, x, w, steps, levels, rows, s, &l, y);
            memcpy(x, y, sizeof(double) * n);
            at += span;
        }
        energy += w[0] * (x[1] - before);
        if (4 * k >= 3 * ticks) late = fmax(late, fabs(x[1]));
    }
    out[0] = energy;
    out[1] = late;
}
