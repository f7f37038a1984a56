// What a fit says to people.
#include "haptics/base/Units.h"
#include "haptics/tuning/TuningFit.h"

#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

double temperatureOf(double soundSpeed_m_s)
{
    // c = 331.3 sqrt(1 + T/273.15)
    return base::kZeroCelsius_K * (std::pow(soundSpeed_m_s / 331.3, 2.0) - 1.0);
}

std::string listed(const std::vector<int>& which)
{
    return which.empty() ? std::string() : ": " + rangesText(which);
}

std::string shiftText(const Eigen::Vector3d& error_m)
{
    return fmt::format(
        "note        a phase that varies evenly across the array looks like a microphone that is "
        "elsewhere,\n"
        "            so phases are known up to a shift of the whole field: of about {:.2f}, "
        "{:.2f}, "
        "{:.2f} mm in x, y, z\n"
        "            by the transducers' own spread, and by as much as something else (a warm "
        "corner) "
        "tilts them.\n"
        "            midair-calibrate takes such a shift up, from where the field is felt.\n",
        1e3 * error_m.x(),
        1e3 * error_m.y(),
        1e3 * error_m.z());
}

std::string placesText(const MicrophoneFit& microphone)
{
    std::string text;
    auto out = std::back_inserter(text);
    for (Eigen::Index p = 0; p < microphone.places.cols(); ++p)
        fmt::format_to(out,
                       "place {:<6}({:.5f}, {:.5f}, {:.5f}) m, +- {:.2f}, {:.2f}, {:.2f} mm\n",
                       p,
                       microphone.places(0, p),
                       microphone.places(1, p),
                       microphone.places(2, p),
                       1e3 * microphone.placeErrors(0, p),
                       1e3 * microphone.placeErrors(1, p),
                       1e3 * microphone.placeErrors(2, p));
    fmt::format_to(out,
                   "sound       {:.2f} +- {:.2f} m/s, as at {:.1f} C\n",
                   microphone.soundSpeed_m_s,
                   microphone.soundSpeedError_m_s,
                   temperatureOf(microphone.soundSpeed_m_s));
    return text;
}

} // namespace

std::string TuningFit::text() const
{
    std::string text;
    for (const std::string& note : notes)
        text += "note        " + note + "\n";
    if (!usable()) return text + "refused     " + refusal + "\n";
    auto out = std::back_inserter(text);
    const auto reversed = of(TransducerState::REVERSED), dead = of(TransducerState::DEAD);
    const auto unsure = of(TransducerState::UNSURE), none = of(TransducerState::NOT_MEASURED);
    fmt::format_to(out,
                   "array       {}, {} transducers: {} fine, {} reversed, {} dead{}\n",
                   array.name,
                   array.size(),
                   of(TransducerState::FINE).size(),
                   reversed.size(),
                   dead.size(),
                   listed(dead));
    if (!unsure.empty())
        fmt::format_to(out, "unsure      {} in too much noise{}\n", unsure.size(), listed(unsure));
    if (!none.empty())
        fmt::format_to(out,
                       "unmeasured  {}, which keep what the array's file says{}\n",
                       none.size(),
                       listed(none));
    fmt::format_to(out,
                   "spread      phases {:.1f} degrees (polarity aside), gains {:.1f} %\n",
                   base::toDegrees(phaseSpread_rad),
                   100.0 * gainSpread);
    text += placesText(microphone);
    if (microphone.places.cols() > 1)
        fmt::format_to(out,
                       "residual    {:.1f} degrees rms between places; expected error of a phase "
                       "{:.1f} degrees\n",
                       base::toDegrees(microphone.scatter_rad),
                       base::toDegrees(expectedError_rad));
    else
        fmt::format_to(out,
                       "residual    not known from one place: reflections look like phases of "
                       "transducers; expected error\n            {:.1f} degrees without them. "
                       "Four places 5 cm apart halve what they do.\n",
                       base::toDegrees(expectedError_rad));
    fmt::format_to(out,
                   "focus       {:.3f} of what the same transducers can do, before these offsets\n",
                   focusBefore);
    return text + shiftText(microphone.shiftError);
}

} // namespace midair::haptics
