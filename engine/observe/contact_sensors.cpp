#include "engine/observe/contact_sensors.h"

#include <algorithm>

#include "engine/assembly/evaluator.h"
#include "engine/contact/contact_forces.h"

namespace lithe {
namespace {

const ContactRecord& record_of(Snapshot& now, const ContactElement& contact) {
  for (const ContactRecord& record : now.system().contacts())
    if (record.element == &contact) return record;
  throw SceneError("'" + contact.name() + "' is not in this system", contact.where(),
                   "use a contact of the assembled graph");
}

void check_collider(const ContactElement& contact, int collider, const Located& name) {
  if (collider < 0 || collider >= contact.marker_count())
    throw SceneError("'" + contact.name() + "' has no collider " + std::to_string(collider), to_string(name.where),
                     "number them from 0 to " + std::to_string(contact.marker_count() - 1) + ", in its list's order");
}

Sensor named(Located name, const ContactElement& contact, const std::string& quantity,
             const std::vector<std::string>& units, Sensor::Reading reading,
             const std::vector<std::string>& endings = {""}) {
  if (name.text.empty()) name.text = contact.name() + "_" + quantity;
  std::vector<std::string> columns;
  for (const std::string& ending : endings) columns.push_back(name.text + ending);
  return {std::move(name), std::move(columns), std::move(reading), units};
}

const std::vector<std::string> kWrenchUnits = {"N", "N", "N", "N m", "N m", "N m"};
const std::vector<std::string> kWrench = {"_force_x", "_force_y", "_force_z", "_moment_x", "_moment_y", "_moment_z"};

void add_load(const ContactTrace& trace, double sign, const Vector3& about, std::span<double> out) {
  const Vector3 force = sign * trace.force, moment = sign * trace.moment + (trace.point.position - about).cross(force);
  for (int i = 0; i < 3; ++i) out[i] += force[i], out[3 + i] += moment[i];
}

}  // namespace

ContactMemory contacts(Snapshot& now, const ContactElement& contact) {
  const int number = record_of(now, contact).number;
  ContactMemory all = now.contacts()->report();
  std::erase_if(all, [&](const ContactTrace& t) { return t.element != number; });
  return all;
}

Sensor contact_force(const ContactElement& contact, int collider, Located name) {
  check_collider(contact, collider, name);
  return named(
      std::move(name), contact, "on_" + std::to_string(collider), kWrenchUnits,
      [&contact, collider](Snapshot& now, std::span<double> out) {
        std::fill(out.begin(), out.end(), 0.0);
        const Vector3 about = now.marker(record_of(now, contact).markers[collider]).p;
        for (const ContactTrace& t : contacts(now, contact)) {
          if (t.point.B.collider == collider) add_load(t, 1, about, out);
          if (t.point.A.collider == collider) add_load(t, -1, about, out);
        }
      },
      kWrench);
}

Sensor contact_force(const ContactElement& contact, int a, int b, Located name) {
  check_collider(contact, a, name), check_collider(contact, b, name);
  return named(
      std::move(name), contact, std::to_string(a) + "_on_" + std::to_string(b), kWrenchUnits,
      [&contact, a, b](Snapshot& now, std::span<double> out) {
        std::fill(out.begin(), out.end(), 0.0);
        const Vector3 about = now.marker(record_of(now, contact).markers[b]).p;
        for (const ContactTrace& t : contacts(now, contact)) {
          if (t.point.A.collider == a && t.point.B.collider == b) add_load(t, 1, about, out);
          if (t.point.A.collider == b && t.point.B.collider == a) add_load(t, -1, about, out);
        }
      },
      kWrench);
}

Sensor gap(const ContactElement& contact, int a, int b, double reach, Located name) {
  check_collider(contact, a, name), check_collider(contact, b, name);
  return named(std::move(name), contact, "gap_" + std::to_string(a) + "_" + std::to_string(b), {"m"},
               [&contact, a, b, reach](Snapshot& now, std::span<double> out) {
                 out[0] = now.contacts()->gap(record_of(now, contact).number, a, b, reach);
               });
}

Sensor penetration(const ContactElement& contact, int a, int b, Located name) {
  check_collider(contact, a, name), check_collider(contact, b, name);
  return named(std::move(name), contact, "penetration_" + std::to_string(a) + "_" + std::to_string(b), {"m"},
               [&contact, a, b](Snapshot& now, std::span<double> out) {
                 out[0] = std::max(0.0, -now.contacts()->gap(record_of(now, contact).number, a, b, 0));
               });
}

namespace {

std::vector<ContactPoint> touching(Snapshot& now, const ContactElement& contact) {
  const std::vector<double> none(contact.marker_count(), 0.0);
  std::vector<ContactPoint> points;
  now.contacts()->find(record_of(now, contact).number, none, points);
  return points;
}

}  // namespace

Sensor penetration(const ContactElement& contact, Located name) {
  return named(std::move(name), contact, "penetration", {"m"}, [&contact](Snapshot& now, std::span<double> out) {
    out[0] = 0;
    for (const ContactPoint& point : touching(now, contact)) out[0] = std::max(out[0], -point.gap);
  });
}

Sensor contact_count(const ContactElement& contact, Located name) {
  return named(std::move(name), contact, "count", {}, [&contact](Snapshot& now, std::span<double> out) {
    out[0] = static_cast<double>(touching(now, contact).size());
  });
}

Sensor contact_energy(const ContactElement& contact, Located name) {
  return named(std::move(name), contact, "energy", {"J"}, [&contact](Snapshot& now, std::span<double> out) {
    out[0] = now.evaluator().workspace().force_energy[record_of(now, contact).energy];
  });
}

Sensor contact_power(const ContactElement& contact, Located name) {
  return named(std::move(name), contact, "power", {"W"}, [&contact](Snapshot& now, std::span<double> out) {
    out[0] = now.contacts()->power(record_of(now, contact).number);
  });
}

}  // namespace lithe
