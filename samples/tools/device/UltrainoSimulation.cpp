#include "samples/tools/device/UltrainoSimulation.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "samples/tools/device/BeanXml.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using base::InputError;

// Defaults of the simulator's classes (Transducer.java): what has them isn't in the file.
constexpr double kPower = 2.53;
constexpr double kAperture_m = 0.009;
constexpr double kFrequency_Hz = 40e3;

constexpr double kMostMetres = 10.0;
constexpr int kMostTransducers = 4096;
constexpr int kChannels = 64; ///< of a driver board

struct Emitter
{
    Eigen::Vector3d position_m;
    Eigen::Vector3d normal;
    double power = kPower;
    double correction_rad = 0.0;
    int pin = 0;
    int order = 0;
};

/// The simulator has y upwards, where a flat array emits; array files have z there.
Eigen::Vector3d upright(const Eigen::Vector3d& v)
{
    return {v.x(), -v.z(), v.y()};
}

class Reader
{
public:
    Reader(const BeanXml& beans, const std::string& source) : _beans(beans), _source(source) {}

    [[noreturn]] void fail(const std::string& what) const
    {
        throw InputError(_source + ": " + what);
    }

    double number(int object, const char* name, double otherwise, double low, double high) const
    {
        const int member = _beans.member(object, name);
        if (member < 0) return otherwise;
        const double value = _beans.number(member);
        if (!(value >= low && value <= high))
            fail(fmt::format("{} of transducer {} is {:g}; it must be a number from {:g} to {:g}",
                             name,
                             _current,
                             value,
                             low,
                             high));
        return value;
    }

    Eigen::Vector3d vector(int object) const
    {
        return {number(object, "x", 0.0, -kMostMetres, kMostMetres),
                number(object, "y", 0.0, -kMostMetres, kMostMetres),
                number(object, "z", 0.0, -kMostMetres, kMostMetres)};
    }

    Emitter emitter(int object)
    {
        Emitter one;
        const int transform = _beans.member(object, "transform");
        const int rotation = _beans.member(transform, "rot");
        one.position_m = upright(vector(_beans.member(transform, "translation")));
        const Eigen::Quaterniond turn(number(rotation, "w", 1.0, -1e6, 1e6),
                                      number(rotation, "x", 0.0, -1e6, 1e6),
                                      number(rotation, "y", 0.0, -1e6, 1e6),
                                      number(rotation, "z", 0.0, -1e6, 1e6));
        if (!(turn.norm() > 1e-3))
            fail(fmt::format("rot of transducer {} is no rotation", _current));
        one.normal = upright(turn.normalized() * Eigen::Vector3d::UnitY()).normalized();
        one.power = number(object, "power", kPower, 1e-6, 1e4);
        one.correction_rad = base::kPi * number(object, "phaseCorrection", 0.0, -1e3, 1e3);
        one.pin = whole(object, "driverPinNumber");
        one.order = whole(object, "orderNumber");
        sameFrequency(number(object, "frequency", kFrequency_Hz, 1e3, 1e6));
        _hasOtherAperture =
            _hasOtherAperture ||
            std::abs(number(object, "apperture", kAperture_m, 0.0, 1.0) - kAperture_m) > 1e-6;
        ++_current;
        return one;
    }

    double frequency_Hz() const { return _frequency_Hz; }
    bool hasOtherAperture() const { return _hasOtherAperture; }

private:
    int whole(int object, const char* name) const
    {
        const double value = number(object, name, 0.0, -1e6, 1e6);
        if (value != std::floor(value))
            fail(
                fmt::format("{} of transducer {} is {:g}, no whole number", name, _current, value));
        return static_cast<int>(value);
    }

    void sameFrequency(double frequency_Hz)
    {
        if (_current > 0 && frequency_Hz != _frequency_Hz)
            fail(fmt::format("transducer {} has {:g} Hz, those before it {:g}; an array has one",
                             _current,
                             frequency_Hz,
                             _frequency_Hz));
        _frequency_Hz = frequency_Hz;
    }

    const BeanXml& _beans;
    const std::string& _source;
    int _current = 0;
    double _frequency_Hz = kFrequency_Hz;
    bool _hasOtherAperture = false;
};

/// Whether \a number tells the emitters apart.
bool areDistinct(const std::vector<Emitter>& all, int Emitter::*number)
{
    std::set<int> seen;
    return std::all_of(all.begin(),
                       all.end(),
                       [&](const Emitter& one)
                       { return one.*number >= 0 && seen.insert(one.*number).second; });
}

/// The wire of each emitter, and the number of wires in \a count.
std::vector<int>
wiresOf(const std::vector<Emitter>& all, int& count, std::vector<std::string>& notes)
{
    const bool isByPin = areDistinct(all, &Emitter::pin);
    const bool isByOrder = !isByPin && areDistinct(all, &Emitter::order);
    std::vector<int> wires;
    for (const Emitter& one : all)
        wires.push_back(isByPin ? one.pin : isByOrder ? one.order : static_cast<int>(wires.size()));
    if (!isByPin)
        notes.push_back(isByOrder ? "pins aren't given for all: transducers stand by orderNumber"
                                  : "neither pins nor orderNumber tell the transducers apart: they "
                                    "stand as in the file");
    const auto size = static_cast<int>(all.size());
    count = *std::max_element(wires.begin(), wires.end()) + 1;
    // Channels without an emitter are on boards that have them all the same.
    if (count > size) count = (count + kChannels - 1) / kChannels * kChannels;
    return wires;
}

/// Puts \a emitters at their \a wires of \a count.
void place(const std::vector<Emitter>& emitters,
           const std::vector<int>& wires,
           int count,
           UltrainoSimulation& made)
{
    haptics::TransducerArray& array = made.array;
    double strongest = 0.0;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Emitter& one : emitters)
    {
        strongest = std::max(strongest, one.power);
        middle += one.position_m / static_cast<double>(emitters.size());
    }
    array.name = "ultraino simulation";
    array.sourceAmplitude_Pa_m = std::max(array.sourceAmplitude_Pa_m, strongest);
    array.positions = middle.replicate(1, count);
    array.normals = Eigen::Vector3d::UnitZ().replicate(1, count);
    array.phaseOffset_rad = Eigen::VectorXd::Zero(count);
    array.gain = Eigen::VectorXd::Ones(count);
    array.board.assign(static_cast<std::size_t>(count), 0);
    std::vector<bool> isThere(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < emitters.size(); ++i)
    {
        const Emitter& one = emitters[i];
        array.positions.col(wires[i]) = one.position_m;
        array.normals.col(wires[i]) = one.normal;
        // The simulator adds the correction to the delay that it sends, so the emitter is early.
        array.phaseOffset_rad[wires[i]] = one.correction_rad;
        array.gain[wires[i]] = one.power / strongest;
        isThere[static_cast<std::size_t>(wires[i])] = true;
    }
    std::vector<int> dead;
    for (int wire = 0; wire < count; ++wire)
        if (!isThere[static_cast<std::size_t>(wire)]) dead.push_back(wire);
    array.setDead(dead);
    if (!dead.empty())
        made.notes.push_back(fmt::format("{} of {} channels have no transducer: they are dead, and "
                                         "stand in the middle of the others",
                                         dead.size(),
                                         count));
}

} // namespace

UltrainoSimulation readUltraino(const std::string& bytes, const std::string& source)
{
    const BeanXml beans(bytes, source, kMostUltrainoXml);
    Reader reader(beans, source);
    const std::vector<int>& listed =
        beans.list(beans.member(beans.only("Simulation"), "transducers"));
    if (listed.empty() || listed.size() > kMostTransducers)
        reader.fail(fmt::format("its simulation has {} transducers; there must be 1 to {}",
                                listed.size(),
                                kMostTransducers));
    std::vector<Emitter> emitters;
    for (const int one : listed)
        emitters.push_back(reader.emitter(one));

    UltrainoSimulation made;
    int count = 0;
    const std::vector<int> wires = wiresOf(emitters, count, made.notes);
    if (count > kMostTransducers)
        reader.fail(fmt::format("a transducer has the pin {}; it must be below {}",
                                *std::max_element(wires.begin(), wires.end()),
                                kMostTransducers));
    place(emitters, wires, count, made);
    made.array.frequency_Hz = reader.frequency_Hz();
    if (reader.hasOtherAperture())
        made.notes.emplace_back("apertures other than 9 mm are not taken: all have the directivity "
                                "of the T4010A1");
    std::string error;
    if (!made.array.isValid(&error)) reader.fail(error);
    return made;
}

} // namespace midair::samples
