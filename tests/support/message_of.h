#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace lithe::test {

/// The message of the error that `action` throws; empty if it throws none.
template <class ExpectedError, class Action>
std::string message_of(Action&& action) {
  try {
    action();
  } catch (const ExpectedError& error) {
    return error.what();
  }
  return "";
}

inline void expect_says(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
}

}  // namespace lithe::test
