#include "converters/stress/stress.h"

#include <array>
#include <random>
#include <utility>

#include "converters/stress/checks.h"

namespace sbrdf::internal {
namespace {

using namespace stress;

constexpr std::array kFrames = {FrameId::kElevation, FrameId::kHalfDifference};
constexpr std::array kDomains = {DomainKind::kLinear, DomainKind::kLog};

struct Topic {
  std::string_view name;
  StressRow (*check)(Trial&);
  bool linear_only = false;
};

constexpr std::array kTopics = {
    Topic{"theta", check_theta},
    Topic{"turns", check_turns},
    Topic{"range", check_range},
    Topic{"zeros", check_zeros},
    Topic{"constants", check_constants},
    Topic{"linear", check_linear, true},
    Topic{"reciprocity", check_reciprocity},
    Topic{"isotropy", check_isotropy},
    Topic{"continuity", check_continuity},
    Topic{"minimum gap", check_minimum_gap},
    Topic{"single samples", check_single},
    Topic{"spikes", check_spikes},
    Topic{"accuracy", check_accuracy},
};

}  // namespace

std::vector<std::string> stress_topics() {
  std::vector<std::string> names;
  for (const Topic& topic : kTopics) names.emplace_back(topic.name);
  return names;
}

std::vector<StressRow> run_stress(std::uint64_t seed, const Progress& progress, const StressSubject& subject) {
  ProgressCounter counter(progress, kTopics.size() * kFrames.size() * kDomains.size() * subject.evaluations.size());
  std::vector<StressRow> rows;
  for (const Topic& topic : kTopics) {
    for (const FrameId frame : kFrames) {
      for (const DomainKind domain : kDomains) {
        for (const StressEvaluation evaluation : subject.evaluations) {
          const bool wanted = subject.topic.empty() || subject.topic == topic.name;
          if (wanted && !(topic.linear_only && domain != DomainKind::kLinear)) {
            Trial trial = {frame, domain, std::mt19937_64(seed), subject, evaluation};
            StressRow row = topic.check(trial);
            row.name = std::string(topic.name) + ", " + std::string(geometry(frame).name()) +
                       (domain == DomainKind::kLog ? ", log" : ", linear") +
                       (evaluation == StressEvaluation::kKernel ? ", kernel" : "");
            rows.push_back(std::move(row));
          }
          if (!counter.advance()) return rows;
        }
      }
    }
  }
  return rows;
}

}  // namespace sbrdf::internal
