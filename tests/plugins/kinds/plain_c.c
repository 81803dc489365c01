/* A joint and an integrator in plain C, by the tables alone: the rod of plugins/massless_rod, and Euler's method with
   velocities first. */
#include <stdlib.h>
#include <string.h>

#include "engine/plugin_abi.h"

static void* rod_create(const lithe_parameter* given, size_t count, char* error, size_t error_size) {
  double* length = (double*)malloc(sizeof(double));
  *length = 1;
  for (size_t i = 0; i < count; ++i) *length = given[i].number;
  if (*length <= 0) {
    strncpy(error, "a rod has a length\ngive one above 0", error_size - 1);
    free(length);
    return NULL;
  }
  return length;
}

static int32_t rod_evaluate(const void* rod, double time, const lithe_marker* m, lithe_rows* rows) {
  const double length = *(const double*)rod;
  double dd = 0, vv = 0;
  (void)time;
  memset(rows->wrench, 0, 12 * sizeof(double));
  for (int i = 0; i < 3; ++i) {
    const double d = m[1].p[i] - m[0].p[i], d_dot = m[1].v[i] - m[0].v[i];
    rows->wrench[i] = -d;
    rows->wrench[6 + i] = d;
    dd += d * d;
    vv += d_dot * d_dot;
  }
  rows->residual[0] = 0.5 * (dd - length * length);
  rows->rate[0] = 0;
  rows->bias[0] = vv;
  rows->no_stiffness = 1;
  return 0;
}

typedef struct {
  double step;
  lithe_equations equations;
  int64_t steps;
  double *increment, *none;
} euler;

static void* euler_create(const lithe_parameter* given, size_t count, char* error, size_t error_size) {
  euler* self = (euler*)calloc(1, sizeof(euler));
  (void)error;
  (void)error_size;
  self->step = count > 0 ? given[0].number : 1e-3;
  return self;
}

static void euler_destroy(void* integrator) {
  euler* self = (euler*)integrator;
  free(self->increment);
  free(self->none);
  free(self);
}

static int32_t accelerate(euler* self, lithe_state* s) {
  const lithe_equations* e = &self->equations;
  const lithe_tangent_weights mass = {0, 0, 1};
  int32_t code;
  if ((code = e->evaluate(e->host, s->time, s->q, s->v, LITHE_ACCELERATION)) != 0) return code;
  if ((code = e->factorize(e->host, &mass, self->none, self->none, NULL)) != 0) return code;
  if ((code = e->residual(e->host, self->none, self->none, s->v_dot)) != 0) return code;
  for (int32_t i = 0; i < e->v_count; ++i) s->v_dot[i] = -s->v_dot[i];
  if ((code = e->constraint(e->host, LITHE_ACCELERATION, s->lambda)) != 0) return code;
  return e->solve(e->host, s->v_dot, s->lambda);
}

static int32_t euler_start(void* integrator, const lithe_equations* equations, lithe_state* s, char* error,
                           size_t size) {
  euler* self = (euler*)integrator;
  const size_t n = (size_t)equations->v_count + (size_t)equations->row_count;
  (void)error;
  (void)size;
  self->equations = *equations;
  self->increment = (double*)realloc(self->increment, n * sizeof(double));
  free(self->none);
  self->none = (double*)calloc(n, sizeof(double));
  return accelerate(self, s);
}

static int32_t euler_step(void* integrator, lithe_state* s, double t_stop, char* error, size_t error_size) {
  euler* self = (euler*)integrator;
  const lithe_equations* e = &self->equations;
  const int last = t_stop - s->time <= self->step * (1 + 1e-9);
  const double h = last ? t_stop - s->time : self->step;
  int32_t code;
  (void)error;
  (void)error_size;
  for (int32_t i = 0; i < e->v_count; ++i) s->v[i] += h * s->v_dot[i];
  for (int32_t i = 0; i < e->v_count; ++i) self->increment[i] = h * s->v[i];
  if ((code = e->retract(e->host, s->q, self->increment, s->q)) != 0) return code;
  s->time = last ? t_stop : s->time + h;
  ++self->steps;
  return accelerate(self, s);
}

static void euler_statistics(const void* integrator, lithe_statistics* out) {
  out->steps = ((const euler*)integrator)->steps;
}

int32_t lithe_plugin_v1(const lithe_host* host) {
  static const lithe_field length = {"length", LITHE_NUMBER, 0}, step = {"step", LITHE_NUMBER, 0};
  static lithe_joint_type rod;
  static lithe_integrator_type method;
  rod.struct_size = sizeof rod;
  rod.name = "c_rod";
  rod.fields = &length;
  rod.field_count = 1;
  rod.marker_count = 2;
  rod.row_count = 1;
  rod.create = rod_create;
  rod.destroy = free;
  rod.evaluate = rod_evaluate;
  host->add_joint(host->context, &rod);
  method.struct_size = offsetof(lithe_integrator_type, save); /* as of before there was save() */
  method.name = "c_euler";
  method.fields = &step;
  method.field_count = 1;
  method.create = euler_create;
  method.destroy = euler_destroy;
  method.start = euler_start;
  method.step = euler_step;
  method.statistics = euler_statistics;
  host->add_integrator(host->context, &method);
  return 0;
}
