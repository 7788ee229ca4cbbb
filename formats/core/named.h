#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace sbrdf::internal {

/// A value with the name that it has in files, options and reports. Tables of them are read in both directions, so that
/// a name is written down once:
///
///     constexpr std::array kDomainNames = {Named{"linear", DomainKind::kLinear}, Named{"log", DomainKind::kLog}};
template <class T>
struct Named {
  std::string_view name;
  T value;
};
// What clang 14 does not deduce by itself.
template <class T>
Named(std::string_view, T) -> Named<T>;

/// The names alone, in the order of the table.
template <class T, std::size_t N>
[[nodiscard]] constexpr std::array<std::string_view, N> names_of(const std::array<Named<T>, N>& table) {
  std::array<std::string_view, N> names;
  for (std::size_t k = 0; k < N; ++k) names[k] = table[k].name;
  return names;
}

/// The value of a name; nothing where the table has no such name.
template <class T, std::size_t N>
[[nodiscard]] constexpr std::optional<T> value_of(const std::array<Named<T>, N>& table, std::string_view name) {
  for (const Named<T>& row : table) {
    if (row.name == name) return row.value;
  }
  return std::nullopt;
}

/// The name of a value; empty where the table has no such value.
template <class T, std::size_t N>
[[nodiscard]] constexpr std::string_view name_of(const std::array<Named<T>, N>& table, const T& value) {
  for (const Named<T>& row : table) {
    if (row.value == value) return row.name;
  }
  return {};
}

}  // namespace sbrdf::internal
