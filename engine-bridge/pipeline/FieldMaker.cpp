#include "engine-bridge/pipeline/FieldMaker.h"

#include "haptics/base/Limits.h"
#include "haptics/base/text/PlainText.h"
#include "haptics/sequence/FieldOrder.h"

#include <algorithm>

namespace midair::bridge
{

haptics::ControlPoints allOf(const std::vector<haptics::ControlPoints>& parts)
{
    haptics::ControlPoints all = parts.front();
    for (std::size_t k = 1; k < parts.size(); ++k)
        haptics::append(all, parts[k]);
    return all;
}

haptics::TimeMultiplexer& FieldMaker::solvers(int set, bool absolute)
{
    const std::pair<int, bool> key(set, absolute);
    const auto found = _solvers.find(key);
    if (found != _solvers.end()) return found->second;
    auto make = [this, absolute] { return _options.makeSolver(absolute); };
    return _solvers.emplace(key, haptics::TimeMultiplexer(make)).first->second;
}

// Each set's solvers keep their matrices, so that they start warm: those of as many sets as there is memory for.
void FieldMaker::makeRoom(const std::pair<int, bool>& key, int points)
{
    int& own = _points[key];
    own = std::max(own, points);
    int all = 0;
    for (const auto& known : _points)
        all += known.second;
    for (auto other = _points.begin(); other != _points.end() && all > base::kMostPointsInTurn;)
    {
        if (other->first == key)
        {
            ++other;
            continue;
        }
        all -= other->second;
        _solvers.erase(other->first);
        _last.erase(other->first);
        other = _points.erase(other);
    }
}

FieldMaker::Beat FieldMaker::beatOf(const std::vector<HapticObject>& objects,
                                    const haptics::ControlPoints& points)
{
    Beat beat;
    const HapticObject* leader = nullptr;
    for (const HapticObject& object : objects)
        if (object.properties.modulationFrequency_Hz > 0.0 &&
            object.properties.modulationDepth > 0.0 &&
            (!leader || object.properties.priority > leader->properties.priority))
            leader = &object;
    if (!leader || points.object.empty()) return beat;
    if (_options.modulation.amplitudeRate_Hz > 0.0)
    {
        _messages.say("everything is modulated as the scene says; the modulation of " +
                      leader->path + " is not played");
        return beat;
    }
    beat.rate_Hz = leader->properties.modulationFrequency_Hz;
    beat.depth.resize(points.size());
    for (Eigen::Index l = 0; l < beat.depth.size(); ++l)
    {
        const auto index = static_cast<std::size_t>(points.object[static_cast<std::size_t>(l)]);
        const HapticProperties& p = objects[index].properties;
        beat.depth[l] = p.modulationFrequency_Hz > 0.0 ? p.modulationDepth : 0.0;
        if (p.modulationFrequency_Hz > 0.0 && p.modulationFrequency_Hz != beat.rate_Hz)
        {
            base::PlainStream text;
            text << objects[index].path << ": is modulated at " << beat.rate_Hz << " Hz as "
                 << leader->path << " is, not at " << p.modulationFrequency_Hz
                 << " Hz: the array plays one field at a time";
            _messages.say(text.str());
        }
    }
    beat.alike = beat.depth.minCoeff() == beat.depth.maxCoeff();
    if (beat.depth.maxCoeff() == 0.0) beat.rate_Hz = 0.0; // what is modulated has no points
    return beat;
}

std::vector<haptics::ControlPoints>
FieldMaker::split(const Beat& beat, const haptics::ControlPoints& points, MadeFields& made)
{
    made.modulation = _options.modulation;
    _options.line.fit(made.modulation,
                      beat.rate_Hz > 0.0 ? beat.rate_Hz : made.modulation.amplitudeRate_Hz);
    if (beat.rate_Hz > 0.0 && !beat.alike)
    {
        const int steps = static_cast<int>(std::clamp(
            made.modulation.fieldRate_Hz / beat.rate_Hz + 1e-9, 2.0, double(kMostSteps)));
        made.modulation.fieldRate_Hz = steps * beat.rate_Hz;
        if (_options.subsets > 1)
            _messages.say("objects that are modulated differently are not played in subsets");
        return haptics::modulationSteps(points, beat.depth, steps);
    }
    if (beat.rate_Hz > 0.0)
    {
        made.modulation.amplitudeRate_Hz = beat.rate_Hz;
        made.modulation.amplitudeDepth = beat.depth[0];
    }
    if (_options.subsets > 1) return haptics::subsetsInTurn(points, _options.subsets);
    return {points};
}

MadeFields FieldMaker::make(int set,
                            const std::vector<HapticObject>& objects,
                            const haptics::ControlPoints& points,
                            bool absolute,
                            const haptics::TransducerArray& array,
                            const haptics::Medium& medium)
{
    MadeFields made;
    const Beat beat = beatOf(objects, points);
    made.parts = split(beat, points, made);
    int all = 0;
    for (const haptics::ControlPoints& part : made.parts)
        all += part.size();
    makeRoom({set, absolute}, all);
    std::vector<Eigen::VectorXcf>& last = _last[{set, absolute}];
    made.report = solvers(set, absolute).solve(made.parts, array, medium, last);
    if (made.report.stop == haptics::StopReason::STOPPED) throw base::Stopped();
    // The first instant of a modulation has all points at their full targets.
    if (beat.rate_Hz > 0.0 && !beat.alike) made.parts.resize(1);
    if (made.report.stop == haptics::StopReason::REFUSED) return made;
    made.fields = last;
    haptics::alignFields(made.fields, array.drive);
    return made;
}

} // namespace midair::bridge
