#pragma once

#include "engine-bridge/pipeline/CappedOutput.h"
#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/pipeline/TurnOnBoard.h"
#include "engine-bridge/rendering/ContactRenderer.h"

#include <memory>

namespace midair::bridge
{

/// Plays objects rendered by contacts: one field at a time, added to the field of whole objects.
/// Sensations that repeat themselves are stored by a device whose line is too slow for them.
class ContactStage final : public PipelineStage
{
public:
    /// All arguments must outlive it.
    ContactStage(PipelineContext& context, CappedOutput& output, HandStage& hands);

    void setOptions() override;
    void setReflectors() override;
    bool arrive(const SceneSnapshot*& snapshot) override;
    bool compose(const haptics::FieldSequence& whole) override;
    bool mayPlayOn() const override { return !_concerns && !_isPlayed; }
    bool takeOver(HologramResult& result) override;
    RestStep attend(bool isPlaying) override;
    std::optional<double> rest_s(bool isPlaying) const override;
    void end() override;

private:
    const SceneSnapshot& withContactShares(const SceneSnapshot& snapshot);
    bool isActive() const;
    double period_s() const;
    void playNext(HologramResult* result);
    bool playTurn(double now_s, double cap_Pa, HologramResult* result);
    bool storeTurn(const haptics::StoredTurn& turn, double now_s, HologramResult& result);
    void continueTurn(HologramResult& result) const;
    void scheduleNext(double now_s);
    RestStep silence();
    RestStep playWhole();

    PipelineContext& _context;
    CappedOutput& _output;
    HandStage& _hands;
    std::unique_ptr<ContactRenderer> _renderer;
    SceneSnapshot _shared;         // the newest, with the shares of its objects
    bool _concerns = false;        // some of its objects may be rendered by contacts
    bool _isPlayed = false;        // the playing field has contacts
    haptics::FieldSequence _whole; // of the whole objects, before caps; kept for contacts
    double _due_s = 0.0;           // steady clock; when the next one is
    double _shown_s = 0.0;         // when the last one was published
    TurnOnBoard _turn;
};

} // namespace midair::bridge
