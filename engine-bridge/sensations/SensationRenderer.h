#pragma once

#include "engine-bridge/hands/TouchMeshes.h"
#include "engine-bridge/sensations/PlayingSensation.h"
#include "engine-bridge/sensations/Precedence.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/probe/Feeling.h"
#include "haptics/propagation/PropagationMatrix.h"

#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// Makes the foci of all sensations of a scene, field by field.
///
/// Of several, those with the highest priority play, at most kMostFoci at once; the others fade.
class SensationRenderer
{
public:
    static constexpr std::size_t kMostFoci = 10; ///< sensations that have a focus in one field

    /// \a array, \a medium: valid; copied.
    SensationRenderer(const haptics::TransducerArray& array, const haptics::Medium& medium);

    /// Plays on \a array from the next field on; copied.
    void setArray(const haptics::TransducerArray& array);

    /// Returns true if \a objects have a sensation.
    static bool concerns(const std::vector<HapticObject>& objects);
    /// Takes a frame at \a time_s of the steady clock, with the \a contacts of its objects.
    void update(const std::vector<HapticObject>& objects,
                const HandFrame& hands,
                const std::vector<Contact>& contacts,
                double time_s);
    void clear(); ///< ends all
    /// Continues the sensations of \a before, which has none afterwards.
    void continueFrom(SensationRenderer& before);
    /// No field is rendered for now: views() play nothing until the next render().
    void pause();

    /// Returns true if a sensation plays or fades.
    bool isActive() const;
    /// Returns the highest priority of those that play; \a lowest if none does.
    int highestPriority(int lowest) const;

    /// Appends the foci of the field at \a now_s, \a dt_s after the last one, on a line of \a
    /// rate_Hz fields a second. \a turn: the fields that the device repeats by itself; null: each
    /// comes over the line. \a levels: factors by priority. ContactFocus::share keeps each below \a
    /// most_Pa (0: no limit) as a whole, so that a cap leaves the course of a sensation.
    void render(double now_s,
                double dt_s,
                double rate_Hz,
                const haptics::StoredTurn* turn,
                double most_Pa,
                Precedence& levels,
                std::vector<ContactFocus>& foci);
    /// Returns what follows the last render() for ever, with the foci of each below \a most_Pa (0:
    /// no limit); none: one of those that play changes or fades.
    std::optional<SteadyTurn> steady(double most_Pa) const;
    /// How the skin feels the last render(). A brush counts as circling and a modulation as
    /// vibrating if the line carries them; outlines alone are held.
    haptics::PlayedAs playedAs() const;
    /// Takes the factor, 0 .. 1, by which a field of sensations alone was lowered: later fields
    /// begin with the lowest one, and rise slowly, since a factor that changed from field to field
    /// would be felt as a vibration.
    void noteCap(double factor, double dt_s);

    std::vector<SensationView> views() const;
    /// What of the last render() isn't played as it should be; about the objects' paths.
    std::vector<base::Message> problems() const;

private:
    /// An object with a sensation.
    struct Item
    {
        PlayingSensation sensation;
        std::string path;
        std::shared_ptr<const void> origin;
        Eigen::Vector3d measured = Eigen::Vector3d::Constant(std::nan("")); ///< place of most_Pa
        double most_Pa = 0.0; ///< of one focus with the whole array
        int index = 0;        ///< of the object in its snapshot
        std::uint64_t seen = 0;
        bool isLeftOut = false;
        double pressure_Pa = 0.0; ///< of intensity 1, without caps, in the last render()
        double level = 0.0;       ///< 0 .. 1; by its priority; 0: it wasn't rendered

        /// The share of its pressure that keeps it below \a most_Pa (0: no limit).
        double shareWithin(double most_Pa) const
        {
            return most_Pa > 0.0 && pressure_Pa > most_Pa ? most_Pa / pressure_Pa : 1.0;
        }
    };

    double mostAt(const Eigen::Vector3d& place);
    Item& itemOf(const HapticObject& object);
    double pressureOf(Item& item);

    haptics::Medium _medium;
    haptics::PropagationMatrix _matrix; ///< of one point
    TouchMeshes _meshes;
    std::map<std::uint64_t, Item> _items; ///< by HapticObject::touchId()
    /// heeded() of those that are gone: one that comes back doesn't play unasked, and one that was
    /// taken away while it played begins anew
    std::map<std::uint64_t, int> _heeded;
    std::uint64_t _updates = 0;
    std::uint64_t _made = 0;
    double _rate_Hz = 0.0;
    std::optional<haptics::StoredTurn> _turn; ///< of the last render()
    double _capped = 1.0;                     ///< 0 .. 1; see noteCap()
};

} // namespace midair::bridge
