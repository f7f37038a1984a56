#include "tests/benchmarks/sensation/Played.h"

#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/Units.h"
#include "haptics/base/threads/Punctual.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/sensation/SensationReader.h"
#include "tests/benchmarks/Timing.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

namespace midair::bench
{

namespace
{

using Eigen::Vector3d;

constexpr double kTurns_Hz = 70.0;
constexpr double kFields_Hz = 1000.0;

bridge::HapticObject circle(int index, int count)
{
    bridge::HapticObject object;
    object.id = static_cast<std::uint64_t>(index) + 1;
    object.path = "circle";
    object.mesh = std::make_shared<const haptics::TriangleMesh>();
    object.pose.translation().x() = 0.045 * (index % 5 - 0.5 * std::min(count - 1, 4));
    object.pose.translation().y() = index < 5 ? 0.0 : 0.06;
    object.properties.pressure = 1000.0;
    object.properties.pressureInPa = true;
    object.properties.sensation.isMeant = true;
    object.properties.sensation.pattern = std::make_shared<const haptics::Sensation>(
        haptics::loadSensation("circle?radius=20mm&frequency=70Hz"));
    return object;
}

/// Returns the place of the highest pressure within 3 mm of \a near in the plane of z, by a
/// parabola through the neighbours of the largest of a grid.
Vector3d
focusOf(const Eigen::VectorXcf& field, const bridge::HologramOptions& options, const Vector3d& near)
{
    constexpr int kHalf = 6;
    constexpr double kStep_m = 0.5e-3;
    constexpr int kSide = 2 * kHalf + 1;
    Eigen::Matrix3Xd places(3, kSide * kSide);
    for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i)
            places.col(j * kSide + i) = near + kStep_m * Vector3d(i - kHalf, j - kHalf, 0.0);
    const Eigen::VectorXd square =
        haptics::meanSquarePressure(places, options.array, options.medium, {field});
    Eigen::Index most = 0;
    square.maxCoeff(&most);
    const int i = static_cast<int>(most) % kSide;
    const int j = static_cast<int>(most) / kSide;
    const auto top = [](double before, double at, double after)
    {
        const double bend = before - 2.0 * at + after;
        return bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
    };
    const auto value = [&](int a, int b)
    { return square[std::clamp(b, 0, kSide - 1) * kSide + std::clamp(a, 0, kSide - 1)]; };
    return near + kStep_m * Vector3d(i - kHalf + top(value(i - 1, j), value(i, j), value(i + 1, j)),
                                     j - kHalf + top(value(i, j - 1), value(i, j), value(i, j + 1)),
                                     0.0);
}

/// What is noted while it plays.
struct Notes
{
    std::vector<double> late_ms;
    std::vector<double> time_s;
    std::vector<double> turns; ///< of the first sensation, mod 1
    std::vector<std::pair<std::shared_ptr<const bridge::TimedField>, Vector3d>> foci;
};

/// Notes the fields of \a result that are newer than the last note.
void note(const bridge::HologramResult& result, Notes& notes)
{
    constexpr std::size_t kMostFoci = 200;
    const bridge::ContactScene& scene = *result.touched;
    const Vector3d centre = circle(0, static_cast<int>(scene.sensations.size())).pose.translation();
    const double last_s = notes.time_s.empty() ? 0.0 : notes.time_s.back();
    for (const bridge::TrailPoint& point : scene.sensations[0].trail)
    {
        if (point.time_s <= last_s) continue;
        const Vector3d from = point.place - centre;
        notes.time_s.push_back(point.time_s);
        notes.turns.push_back(std::atan2(from.y(), from.x()) / base::kTwoPi);
        if (point.time_s == scene.recent.back()->time_s && notes.foci.size() < kMostFoci)
            notes.foci.emplace_back(scene.recent.back(), point.place);
    }
    notes.late_ms.push_back(1e3 * (result.handedOver_s - notes.time_s.back()));
}

void rateTurns(const Notes& notes, PlayedFigures& figures)
{
    double sum = 0.0;
    std::vector<double> all = {0.0};
    for (std::size_t k = 1; k < notes.turns.size(); ++k)
    {
        const double wanted = kTurns_Hz * (notes.time_s[k] - notes.time_s[k - 1]);
        double step = notes.turns[k] - notes.turns[k - 1] - wanted;
        step -= std::round(step);
        sum += wanted + step;
        all.push_back(sum);
    }
    const double length_s = notes.time_s.back() - notes.time_s.front();
    figures.frequency_Hz = sum / length_s;
    for (std::size_t k = 0; k < all.size(); ++k)
        figures.mostJump_turns =
            std::max(figures.mostJump_turns,
                     std::abs(all[k] - figures.frequency_Hz * (notes.time_s[k] - notes.time_s[0])));
}

void rateFoci(const Notes& notes, const bridge::HologramOptions& options, PlayedFigures& figures)
{
    double square = 0.0;
    for (const auto& [field, place] : notes.foci)
    {
        const double away_mm = 1e3 * (focusOf(field->q, options, place) - place).norm();
        square += away_mm * away_mm;
        figures.away_mm[1] = std::max(figures.away_mm[1], away_mm);
    }
    if (!notes.foci.empty())
        figures.away_mm[0] = std::sqrt(square / static_cast<double>(notes.foci.size()));
}

} // namespace

PlayedFigures wakeOnly(double duration_s)
{
    constexpr double kPeriod_s = 1.0 / kFields_Hz;
    base::wakePunctually();
    const double begin_s = base::steadySeconds();
    const double begin_ms = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
    std::vector<double> late_ms;
    double due_s = begin_s + kPeriod_s;
    for (double now_s = begin_s; now_s - begin_s < duration_s;)
    {
        std::this_thread::sleep_for(
            std::chrono::duration<double>(std::max(due_s - base::steadySeconds(), 0.0)));
        now_s = base::steadySeconds();
        late_ms.push_back(1e3 * (now_s - due_s));
        // As ContactStage keeps to its clock.
        const double missed = std::max(std::floor((now_s - due_s) / kPeriod_s), 0.0);
        due_s += (1.0 + missed) * kPeriod_s;
    }
    PlayedFigures figures;
    const double took_s = base::steadySeconds() - begin_s;
    figures.fields_Hz = static_cast<double>(late_ms.size()) / took_s;
    figures.skipped = std::max(1.0 - figures.fields_Hz / kFields_Hz, 0.0);
    figures.core = 1e-3 * (cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - begin_ms) * kFields_Hz /
                   static_cast<double>(late_ms.size());
    figures.late_ms[0] = base::percentile(late_ms, 0.5);
    figures.late_ms[1] = base::percentile(late_ms, 0.99);
    return figures;
}

PlayedFigures playCircles(int sensations, const std::string& device, double duration_s)
{
    base::wakePunctually(); // as HologramThread does
    bridge::HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.fieldRate = kFields_Hz;
    options.deviceUri = device;
    bridge::HologramPipeline pipeline(options);
    bridge::SceneSnapshot snapshot;
    for (int i = 0; i < sensations; ++i)
        snapshot.objects.push_back(circle(i, sensations));
    snapshot.time_s = base::steadySeconds();
    pipeline.process(snapshot);

    Notes notes;
    const auto fields = [&] { return pipeline.counters().contactFields; };
    const double begin_s = base::steadySeconds();
    const double begin_ms = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
    double measuring_ms = 0.0;
    const std::uint64_t before = fields();
    while (base::steadySeconds() - begin_s < duration_s)
    {
        const auto result = pipeline.attend();
        if (result && result->touched && !result->touched->sensations.empty() &&
            !result->touched->recent.empty())
        {
            const double now_ms = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
            note(*result, notes);
            measuring_ms += cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - now_ms;
        }
        std::this_thread::sleep_for(std::chrono::duration<double>(pipeline.rest_s()));
    }
    PlayedFigures figures;
    const double took_s = base::steadySeconds() - begin_s;
    const auto played = static_cast<double>(fields() - before);
    figures.fields_Hz = played / took_s;
    figures.skipped = std::max(1.0 - figures.fields_Hz / options.fieldRate, 0.0);
    figures.core = 1e-3 * (cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - begin_ms - measuring_ms) *
                   options.fieldRate / std::max(played, 1.0);
    figures.late_ms[0] = base::percentile(notes.late_ms, 0.5);
    figures.late_ms[1] = base::percentile(notes.late_ms, 0.99);
    rateFoci(notes, options, figures);
    if (notes.turns.size() > 2) rateTurns(notes, figures);
    return figures;
}

} // namespace midair::bench
