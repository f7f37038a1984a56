#pragma once

#include "engine-bridge/pipeline/CappedOutput.h"
#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/rendering/ContactRenderer.h"

#include <memory>

namespace midair::bridge
{

/// Plays objects that are felt where hands touch them: a field at a time, on top of what is played
/// of whole objects.
class ContactStage final : public PipelineStage
{
public:
    /// All must outlive it.
    ContactStage(PipelineContext& context, CappedOutput& output, HandStage& hands);

    void setOptions() override;
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
    RestStep silence();
    RestStep playWhole();

    PipelineContext& _context;
    CappedOutput& _output;
    HandStage& _hands;
    std::unique_ptr<ContactRenderer> _renderer;
    SceneSnapshot _shared;         // the newest, with the objects' shares
    bool _concerns = false;        // its objects may be felt by contacts
    bool _isPlayed = false;        // what is played has contacts
    haptics::FieldSequence _whole; // of the whole objects, before caps; kept where contacts may be
    double _field_s = 0.0;         // steady clock, when the last one was played
    double _shown_s = 0.0;         // when the last one was published
};

} // namespace midair::bridge
