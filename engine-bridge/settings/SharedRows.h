#pragma once

#include "engine-bridge/sensations/SensationTexts.h"
#include "haptics/base/Limits.h"
#include "haptics/base/settings/SettingTable.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/base/text/Quantity.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

// Settings and properties shared by scene files and the C interface, with the same names, ranges,
// words and help: rows of SceneSettings and ObjectSettings, for structs that inherit from them.
namespace midair::bridge
{

/// Returns the problem of the listening places of \a settings; empty: none.
template<typename S>
std::string problemOfEarPoints(const S& settings)
{
    std::vector<std::array<double, 3>> places;
    if (base::parsePlaces(settings.earPoints, places)) return {};
    return "earPoints is \"" + settings.earPoints + "\", should be " + base::kPlacesExpected;
}

/// Rows of SceneSettings \a S for hands and ears.
template<typename S>
std::vector<base::Setting<S>> handRows()
{
    using base::Effect;
    return {
        base::Row<S>("reach", &S::reach, "solve only points this near to a hand; 0: all")
            .range(0.0, 10.0, "m")
            .variable("REACH")
            .safety()
            .effect(Effect::NOTHING),
        base::Row<S>("shadows",
                     &S::shadows,
                     "hands and obstacles block sound, which the solver takes into account")
            .effect(Effect::NOTHING),
        base::Row<S>(
            "earPoints",
            &S::earPoints,
            std::string("listening places besides those around the array, in its frame: ") +
                base::kPlacesExpected)
            .variable("EAR_POINTS")
            .safety()
            .judgedBy(problemOfEarPoints<S>),
        base::Row<S>("prediction",
                     base::choiceOf<S, &S::prediction>(),
                     "who predicts hands to when the sound arrives: nobody, the tracker, or the "
                     "kit by one of three filters")
            .words({{"off", "OFF", S::OFF},
                    {"tracker", "TRACKER", S::TRACKER},
                    {"alpha-beta", "ALPHA_BETA", S::ALPHA_BETA},
                    {"kalman", "KALMAN", S::KALMAN},
                    {"one-euro", "ONE_EURO", S::ONE_EURO}})
            .variable("PREDICTION")
            .effect(Effect::NOTHING)
            .noIdentity(),
        base::Row<S>("trackerDelay",
                     &S::trackerDelay,
                     "the tracker's own delay, which prediction compensates")
            .range(0.0, 0.2, "s")
            .variable("TRACKER_DELAY")
            .effect(Effect::NOTHING)
            .noIdentity()};
}

/// Rows of SceneSettings \a S for contacts and the air.
template<typename S>
std::vector<base::Setting<S>> contactRows()
{
    using base::Effect;
    return {
        base::Row<S>("render",
                     base::choiceOf<S, &S::render>(),
                     "what is played of objects: the whole, foci on the skin where hands touch, or "
                     "auto: these while hands are known well enough")
            .words({{"object", "OBJECT", S::OBJECT},
                    {"contact", "CONTACT", S::CONTACT},
                    {"auto", "AUTO", S::AUTO}})
            .variable("RENDER"),
        base::Row<S>("contactRate", &S::contactRate, "turns a second of the foci of a contact")
            .range(0.0, 100.0, "Hz"),
        base::Row<S>("contactStep", &S::contactStep, "longest step of a focus from field to field")
            .range(5e-5, 5e-3, "m"),
        base::Row<S>("contactFoci", &S::contactFoci, "most foci of a contact").range(1, 10),
        base::Row<S>("contactMask",
                     &S::contactMask,
                     "transducers behind the finger are off, so that its other side isn't pressed"),
        base::Row<S>(
            "trackerError", &S::trackerError, "accuracy of the hand tracker, used by render=auto")
            .range(0.0, 0.1, "m"),
        base::Row<S>("temperatureSource",
                     &S::temperatureSource,
                     "file or pipe of a thermometer, a reading in C a line, that the temperature "
                     "follows, or a name from the user's grants")
            .variable("TEMPERATURE_SOURCE")
            .effect(Effect::NOTHING)
            .wish(),
        // Longer times would exceed the frames that a scene submits after hands are gone.
        base::Row<S>("contactHold",
                     &S::contactHold,
                     "how long contacts last after the tracker lost the hand")
            .range(0.0, 0.3, "s")};
}

/// Rows of SceneSettings \a S for the coincidence of sight and touch.
template<typename S>
std::vector<base::Setting<S>> seenRows()
{
    using base::Effect;
    return {
        base::Row<S>("extrapolate",
                     &S::extrapolate,
                     "moving objects are played where they are seen when the sound arrives")
            .effect(Effect::NOTHING)
            .noIdentity(),
        base::Row<S>("displayLatency",
                     &S::displayLatency,
                     "time from a frame's stamp to its light, for extrapolating moving objects")
            .range(0.0, 0.2, "s")
            .effect(Effect::NOTHING)
            .noIdentity(),
        base::Row<S>("headError",
                     &S::headError,
                     "error of the head's position, for the distance between seen and felt "
                     "objects; 0: unknown")
            .range(1e-5, 1.0, "m")
            .orZero()
            .effect(Effect::NOTHING)
            .noIdentity(),
        base::Row<S>("arrayError",
                     &S::arrayError,
                     "error of the array's position, as midair-calibrate reports it; 0: unknown")
            .range(1e-5, 1.0, "m")
            .orZero()
            .effect(Effect::NOTHING)
            .noIdentity(),
        base::Row<S>("airError",
                     &S::airError,
                     "error of the air's temperature; 0: 0.5 C with a thermometer, else unknown")
            .range(1e-3, 50.0, "C")
            .orZero()
            .effect(Effect::NOTHING)
            .noIdentity()};
}

/// Rows of SceneSettings \a S except those of FieldSettings.
template<typename S>
std::vector<base::Setting<S>> sceneRows()
{
    return base::joined<S>({handRows<S>(), contactRows<S>(), seenRows<S>()});
}

/// Parses "2", "50 %", "2 relative", "500 Pa", "1.2kPa". Without a unit the present unit stays.
template<typename P>
bool setPressure(P& property, const std::string& text)
{
    double value = 0.0;
    std::string unit;
    if (!base::splitQuantity(text, value, unit)) return false;
    const bool isPascal = base::isUnitFor(unit, "Pa");
    if (isPascal)
        base::parseQuantity(text, "Pa", value);
    else if (unit == "%")
        base::parseQuantity(text, "", value);
    else if (!unit.empty() && unit != "relative")
        return false;
    property.pressure = value;
    if (!unit.empty()) property.pressureUnit = isPascal ? P::PASCAL : P::RELATIVE;
    return true;
}

/// Rows of ObjectSettings \a P for the strength of an object.
template<typename P>
std::vector<base::Setting<P>> strengthRows()
{
    return {
        base::Row<P>("enabled", &P::enabled, "false: the object is not felt").safety(),
        base::Row<P>(
            "pressure",
            &P::pressure,
            "relative to the scene's other objects (the array plays as loud as the field stays "
            "accurate), or peak pressure with its unit: 500 Pa")
            .range(1e-6, 1e5)
            .parsedBy(setPressure<P>)
            .safety(),
        base::Row<P>("unit", base::choiceOf<P, &P::pressureUnit>(), "unit of the pressure")
            .words({{"relative", "RELATIVE", P::RELATIVE}, {"Pa", "PASCAL", P::PASCAL}})
            .stored("PressureUnit")
            .safety(),
        base::Row<P>("spacing", &P::spacing, "distance between control points; 0: one wavelength")
            .range(0.001, 1.0, "m")
            .orZero(),
        base::Row<P>(
            "sampling",
            base::choiceOf<P, &P::sampling>(),
            "where control points are placed: on the faces, along edges, or at the mesh's vertices")
            .words({{"surface", "SURFACE", P::SURFACE},
                    {"edges", "EDGES", P::EDGES},
                    {"vertices", "VERTICES", P::VERTICES}}),
        base::Row<P>(
            "side",
            base::choiceOf<P, &P::side>(),
            "side of the faces that is felt; front: towards where most of the array's sound "
            "comes from")
            .words({{"both", "BOTH", P::BOTH},
                    {"front", "FRONT", P::FRONT},
                    {"back", "BACK", P::BACK}}),
        base::Row<P>(
            "priority",
            &P::priority,
            "objects with a larger one keep their points where points are too near or too many")
            .range(-1000000, 1000000),
        base::Row<P>(
            "modulationFrequency",
            &P::modulationFrequency,
            "modulation of the pressure on the skin; 0: steady; all objects of a scene share "
            "the frequency of the highest priority")
            .range(0.0, base::kMostModulation_Hz, "Hz"),
        base::Row<P>(
            "modulationDepth", &P::modulationDepth, "share of the pressure that modulation removes")
            .range(0.0, 1.0)};
}

/// Rows of ObjectSettings \a P for touched objects.
template<typename P>
std::vector<base::Setting<P>> touchRows()
{
    return {
        base::Row<P>(
            "touchEvents", &P::touchEvents, "report hands that begin and end to touch the object"),
        base::Row<P>("render",
                     base::choiceOf<P, &P::render>(),
                     "what is played of the object: as the scene says, the whole, foci on the skin "
                     "where hands touch it, or auto")
            .words({{"inherit", "INHERIT", P::INHERIT},
                    {"object", "OBJECT", P::OBJECT},
                    {"contact", "CONTACT", P::CONTACT},
                    {"auto", "AUTO", P::AUTO}}),
        base::Row<P>(
            "material",
            &P::material,
            "how it feels where it is touched: skin, rubber, glass, sandpaper, cloth, or a "
            "name from the file that OSG_MIDAIR_MATERIALS names"),
        base::Row<P>("stiffness", &P::stiffness, "applied force over depth; 0: the material's")
            .range(0.1, 1e4, "N/m")
            .orZero(),
        base::Row<P>(
            "contactForce", &P::contactForce, "where the force stops growing; 0: the material's")
            .range(1e-4, 1.0, "N")
            .orZero()
            .safety(),
        base::Row<P>("softness",
                     &P::softness,
                     "growth of the circle's radius over the depth; 0: the material's")
            .range(0.001, 10.0)
            .orZero(),
        base::Row<P>("roughness",
                     &P::roughness,
                     "share of the pressure that the texture takes away; 0: the material's")
            .range(0.001, 1.0)
            .orZero(),
        base::Row<P>(
            "texturePeriod", &P::texturePeriod, "wavelength of the texture; 0: the material's")
            .range(1e-5, 1.0, "m")
            .orZero(),
        base::Row<P>("lowVibration",
                     &P::lowVibration,
                     "share that a vibration of 30 Hz takes away; 0: the material's")
            .range(0.001, 1.0)
            .orZero(),
        base::Row<P>("highVibration",
                     &P::highVibration,
                     "share that a vibration of 150 Hz takes away; 0: the material's")
            .range(0.001, 1.0)
            .orZero()};
}

/// Returns the problem of the attachment of \a settings; empty: none.
template<typename P>
std::string problemOfAttach(const P& settings)
{
    return problemOfAttachment(settings.attach);
}

/// Returns the problem of the parameters of \a settings; empty: none.
template<typename P>
std::string problemOfParameters(const P& settings)
{
    std::vector<std::pair<std::string, double>> values;
    return readParameters(settings.parameters, values);
}

/// Rows of ObjectSettings \a P for sensations.
template<typename P>
std::vector<base::Setting<P>> sensationRows()
{
    return {
        base::Row<P>("sensation",
                     &P::sensation,
                     "sensation that is played instead of the surface: a classic with parameters, "
                     "circle?radius=20mm, the path of an .adaptics file, or such a file's text"),
        base::Row<P>("attach",
                     &P::attach,
                     "where the sensation is played: place, surface, or a joint of a hand: "
                     "hand:palm, hand:index_tip")
            .judgedBy(problemOfAttach<P>),
        base::Row<P>("trigger",
                     base::choiceOf<P, &P::trigger>(),
                     "when the sensation is played: always, by the program's plays, or by touches "
                     "of the object")
            .words({{"always", "ALWAYS", P::ALWAYS},
                    {"program", "PROGRAM", P::PROGRAM},
                    {"touch-begin", "TOUCH_BEGIN", P::TOUCH_BEGIN},
                    {"touch-stay", "TOUCH_STAY", P::TOUCH_STAY},
                    {"touch-end", "TOUCH_END", P::TOUCH_END}}),
        base::Row<P>("sensationSpeed", &P::sensationSpeed, "factor on the sensation's speed")
            .range(0.0, 10.0),
        base::Row<P>("seed", &P::seed, "seed of the sensation's random intensities")
            .range(1, 1000000),
        base::Row<P>(
            "parameters", &P::parameters, "parameters of the sensation: strength=0.4; size=3")
            .judgedBy(problemOfParameters<P>),
        base::Row<P>("plays",
                     &P::plays,
                     "begins a sensation with trigger=program: each other number above 0 begins it "
                     "anew, 0 ends it")
            .range(0, 1000000000)};
}

} // namespace midair::bridge
