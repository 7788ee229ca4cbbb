#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace sbrdf::internal {

/// A figure, a count, a name, yes or no, or nothing.
using Figure = std::variant<std::monostate, double, std::uint64_t, std::string, bool>;

/// A column of what a run of measurements tells: CSV, JSON and the tables for people all go by these, so that they
/// agree.
template <class Row>
struct Column {
  std::string_view key;  ///< in CSV and JSON, with the unit
  Figure (*of)(const Row& row);
};

/// Six significant digits; empty for nothing, a NaN or an infinity. Names as they are; "yes", "no".
[[nodiscard]] std::string figure_text(const Figure& figure);
/// The number that figure_text() tells, null where that is empty.
[[nodiscard]] nlohmann::ordered_json figure_json(const Figure& figure);

/// A name as a cell of a CSV file, in quotes.
[[nodiscard]] std::string csv_cell(std::string_view text);

/// A head and a line for each row; the last column, `last_key`, is the same for all.
template <class Row>
[[nodiscard]] std::string csv_of(std::span<const Row> rows, std::span<const Column<Row>> columns,
                                 std::string_view last_key, std::string_view last) {
  std::string csv;
  for (const Column<Row>& column : columns) csv.append(column.key).append(",");
  csv.append(last_key).append("\n");
  for (const Row& row : rows) {
    for (const Column<Row>& column : columns) {
      const Figure figure = column.of(row);
      const bool is_name = std::holds_alternative<std::string>(figure);
      csv += (is_name ? csv_cell(figure_text(figure)) : figure_text(figure)) + ",";
    }
    csv += csv_cell(last) + "\n";
  }
  return csv;
}

/// An object for each row.
template <class Row>
[[nodiscard]] nlohmann::ordered_json json_of(std::span<const Row> rows, std::span<const Column<Row>> columns) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    for (const Column<Row>& column : columns) object[std::string(column.key)] = figure_json(column.of(row));
    list.push_back(std::move(object));
  }
  return list;
}

}  // namespace sbrdf::internal
