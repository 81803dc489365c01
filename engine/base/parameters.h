#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "engine/base/math.h"

/// Parameters by name: how a scene sets those of a type that it knows only by name, and how a type lists its own.
namespace lithe {

/// {"length", 0.5}, {"mesh", "brick.inp"}, {"axis", {0, 0, 1}}: a number (or true, false), a text, or a vector.
struct Parameter {
  using Value = std::variant<double, std::string, std::vector<double>>;
  std::string name;
  Value value;

  template <class Number>
  requires std::is_arithmetic_v<Number> Parameter(std::string its_name, Number number)
      : name(std::move(its_name)), value(static_cast<double>(number)) {}
  Parameter(std::string its_name, const char* text) : name(std::move(its_name)), value(std::string(text)) {}
  Parameter(std::string its_name, std::string text) : name(std::move(its_name)), value(std::move(text)) {}
  Parameter(std::string its_name, const std::filesystem::path& path)
      : name(std::move(its_name)), value(path.string()) {}
  Parameter(std::string its_name, std::initializer_list<double> vector)
      : name(std::move(its_name)), value(std::vector<double>(vector)) {}
  Parameter(std::string its_name, std::vector<double> vector) : name(std::move(its_name)), value(std::move(vector)) {}
  template <class Derived>
  Parameter(std::string its_name, const Eigen::MatrixBase<Derived>& matrix)  // a matrix goes by columns
      : name(std::move(its_name)) {
    const MatrixX all = matrix;
    value = std::vector<double>(all.data(), all.data() + all.size());
  }
};
using ParameterList = std::vector<Parameter>;

/// A member of a type's Parameters that may be given by name:
///   static constexpr Field<Parameters> kParameters[] = {{"length", &Parameters::length}};
template <class Parameters>
struct Field {
  template <class T>
  using Of = T Parameters::*;
  const char* name;
  std::variant<Of<double>, Of<int>, Of<bool>, Of<std::string>, Of<std::filesystem::path>, Of<Vector3>, Of<Matrix3>,
               Of<std::vector<double>>, Of<VectorX>>
      member;
};

}  // namespace lithe
