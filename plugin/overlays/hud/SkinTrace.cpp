#include "plugin/overlays/hud/SkinTrace.h"

#include "engine-bridge/rendering/ContactView.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/probe/PressureProbe.h"
#include "plugin/engine/HapticEngine.h"

#include <chrono>
#include <optional>

namespace osgMidair
{

namespace
{

using midair::bridge::ContactScene;
using midair::bridge::ContactView;
using midair::bridge::HologramResult;

constexpr double kTracePause_s = 0.1;
constexpr double kSettled_s = 2e-3; ///< 0.4 m of air, and five time constants of a transducer
constexpr double kRate_Hz = 4000.0; ///< of the curve: 200 values in 50 ms

/// Returns the position of the focus with the largest wanted pressure, if there is one.
std::optional<Eigen::Vector3d> strongest(const ContactScene& scene)
{
    std::optional<Eigen::Vector3d> place;
    double most_Pa = 0.0;
    for (const ContactView& contact : scene.contacts)
        for (Eigen::Index l = 0; l < contact.foci.cols(); ++l)
            if (contact.pressure_Pa[l] > most_Pa)
            {
                most_Pa = contact.pressure_Pa[l];
                place = contact.foci.col(l);
            }
    return place;
}

/// Returns the recent fields in sequence; the last one lasts a millisecond.
midair::haptics::DriveSchedule scheduleOf(const ContactScene& scene, int transducers)
{
    midair::haptics::DriveSchedule schedule;
    schedule.repeats = false;
    for (std::size_t i = 0; i < scene.recent.size(); ++i)
    {
        const midair::bridge::TimedField& field = *scene.recent[i];
        if (field.q.size() != transducers) return {};
        const double until_s =
            i + 1 < scene.recent.size() ? scene.recent[i + 1]->time_s : field.time_s + 1e-3;
        if (!(until_s > field.time_s)) continue;
        schedule.steps.push_back(
            {static_cast<int>(schedule.drives.size()), 1.0, until_s - field.time_s});
        schedule.drives.push_back(field.q);
    }
    return schedule;
}

} // namespace

SkinCurve skinCurveOf(const HologramResult& result, const midair::bridge::PlayedDrives& played)
{
    SkinCurve curve;
    if (!result.touched || !result.array) return curve;
    const auto place = strongest(*result.touched);
    if (!place) return curve;
    const bool isKnown = !played.fields.empty();
    midair::haptics::ProbeOptions when =
        midair::bridge::lastMoments(ContactScene::kRecent_s, kRate_Hz);
    midair::haptics::DriveSchedule schedule =
        isKnown ? midair::bridge::scheduleOf(played)
                : scheduleOf(*result.touched, result.array->size());
    if (!isKnown)
    {
        when.begin_s = kSettled_s;
        when.duration_s = schedule.duration_s() - kSettled_s;
    }
    if (schedule.steps.empty() || when.duration_s * kRate_Hz < 2.0) return curve;
    // A place that can't be probed has no curve.
    const std::string thrown = midair::base::thrownBy(
        [&]
        {
            const midair::haptics::PressureProbe probe(
                *result.array, result.medium, std::move(schedule));
            curve.pressure_Pa = midair::haptics::radiationOf(probe.at(*place, when), result.medium);
            curve.duration_s = static_cast<double>(curve.pressure_Pa.size() - 1) / kRate_Hz;
        });
    return thrown.empty() && curve.pressure_Pa.allFinite() ? curve : SkinCurve();
}

void SkinTrace::update(const std::shared_ptr<const HologramResult>& result,
                       const HapticEngine* engine,
                       double now_s)
{
    if (_coming.valid())
    {
        if (_coming.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
        _curve = _coming.get();
    }
    const bool isTouched = result && result->touched && strongest(*result->touched) &&
                           result->state == midair::bridge::ArrayState::PLAYING;
    if (!isTouched) _curve = {};
    if (!isTouched || (_begun_s >= 0.0 && now_s - _begun_s < kTracePause_s)) return;
    _begun_s = now_s;
    midair::bridge::PlayedDrives played;
    if (engine) played = engine->playedOfLate(ContactScene::kRecent_s);
    _coming =
        std::async(std::launch::async,
                   [result, played = std::move(played)] { return skinCurveOf(*result, played); });
}

} // namespace osgMidair
