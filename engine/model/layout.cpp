#include "engine/model/layout.h"

#include "engine/base/error.h"
#include "engine/base/lane_rotations.h"

namespace lithe {

void Layout::add_body(const Body& body) { add_body(body.name(), body.coordinates(), &body); }

void Layout::add_body(std::string name, const Coordinates& c, const Body* body) {
  if (c.frames <= 1) bodies_.push_back({body, q_count_, v_count_, c.frames == 1, c.linear, std::move(name)});
  for (int i = 0; i < c.frames && c.frames > 1; ++i)
    bodies_.push_back({body, q_count_ + 7 * i, v_count_ + 6 * i, true, 0, name + " frame " + std::to_string(i), i});
  if (c.frames > 1 && c.linear > 0)
    bodies_.push_back({body, q_count_ + 7 * c.frames, v_count_ + 6 * c.frames, false, c.linear, name, c.frames});
  q_count_ += c.q_count();
  v_count_ += c.v_count();
}

void Layout::add_rows(std::string name, int count) {
  rows_.push_back({std::move(name), row_count_, count});
  row_count_ += count;
}

std::vector<std::string> Layout::body_names() const {
  std::vector<std::string> names;
  for (const BodySlice& b : bodies_)
    if (b.part == 0) names.push_back(b.body ? b.body->name() : b.name);
  return names;
}

const Layout::BodySlice& Layout::slice(const Body& body) const {
  for (const BodySlice& b : bodies_)
    if (b.body == &body) return b;
  throw SceneError("body '" + body.name() + "' has no coordinates in this system", body.where(),
                   "use a body of the graph that was assembled, added before assemble()");
}

Layout::LinearSlice Layout::linear_slice(const BodySlice& of) const {
  const BodySlice* last = &of;
  while (last != &bodies_.back() && last[1].body == of.body) ++last;
  return {last->q + (last->frame ? 7 : 0), last->v + (last->frame ? 6 : 0), last->linear};
}

void Layout::retract(ConstVectorRef q, ConstVectorRef d, VectorRef out) const {
  retract(0, static_cast<int>(bodies_.size()), q, d, out);
}

void Layout::retract(int first, int last, ConstVectorRef q, ConstVectorRef d, VectorRef out) const {
  const double *from = q.data(), *by = d.data();
  double* to = out.data();
  for (int body = first; body < last; ++body) {
    const BodySlice& b = bodies_[body];
    int iq = b.q, iv = b.v;
    if (b.frame) {
      lanes::store3(lanes::load3(from + iq) + lanes::load3(by + iv), to + iq);
      lanes::store4(lanes::rotated(lanes::load4(from + iq + 3), lanes::load3(by + iv + 3)), to + iq + 3);
      iq += 7, iv += 6;
    }
    for (int i = 0; i < b.linear; ++i) to[iq + i] = from[iq + i] + by[iv + i];
  }
}

void Layout::chart_rates(ConstVectorRef d, ConstVectorRef v, VectorRef d_dot) const {
  d_dot = v;
  for (const BodySlice& b : bodies_)
    if (b.frame) d_dot.segment<3>(b.v + 3) = chart_rate(d.segment<3>(b.v + 3), v.segment<3>(b.v + 3));
}

void Layout::difference(ConstVectorRef q_from, ConstVectorRef q_to, VectorRef d) const {
  for (const BodySlice& b : bodies_) {
    int iq = b.q, iv = b.v;
    if (b.frame) {
      d.segment<3>(iv) = q_to.segment<3>(iq) - q_from.segment<3>(iq);
      const Vector4 from = q_from.segment<4>(iq + 3), to = q_to.segment<4>(iq + 3);
      const Vector4 turn = quaternion_product({from[0], -from[1], -from[2], -from[3]}, to);
      const double s = turn.tail<3>().norm(), angle = 2 * std::atan2(s, std::abs(turn[0]));
      const double sign = turn[0] < 0 ? -1 : 1;
      d.segment<3>(iv + 3) = (s > 1e-300 ? sign * angle / s : 2.0) * turn.tail<3>();
      iq += 7, iv += 6;
    }
    d.segment(iv, b.linear) = q_to.segment(iq, b.linear) - q_from.segment(iq, b.linear);
  }
}

void Layout::magnitudes(ConstVectorRef q, VectorRef out) const {
  for (const BodySlice& b : bodies_) {
    int iq = b.q, iv = b.v;
    if (b.frame) {
      out.segment<3>(iv) = q.segment<3>(iq).cwiseAbs();
      out.segment<3>(iv + 3).setOnes();
      iq += 7, iv += 6;
    }
    out.segment(iv, b.linear) = q.segment(iq, b.linear).cwiseAbs();
  }
}

std::string Layout::velocity_name(int index) const {
  static const char* const names[] = {"p_x", "p_y", "p_z", "omega_x", "omega_y", "omega_z"};
  for (const BodySlice& b : bodies_) {
    const int local = index - b.v, frame = b.frame ? 6 : 0;
    if (local < 0 || local >= frame + b.linear) continue;
    return b.name + ": " + (local < frame ? names[local] : "eta_" + std::to_string(local - frame + 1));
  }
  return "coordinate " + std::to_string(index);
}

std::string Layout::row_name(int index) const {
  for (const RowSlice& r : rows_)
    if (index >= r.first && index < r.first + r.count)
      return "'" + r.name + "' row " + std::to_string(index - r.first + 1);
  return "row " + std::to_string(index);
}

}  // namespace lithe
