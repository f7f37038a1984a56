#pragma once

#include "haptics/base/threads/Mutex.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"

#include <string>

namespace osgMidair
{

/// The engine of an owner that frames visit (a HapticCallback, a HapticDevice): one for the played
/// node, replaced when that node changes. All functions except playing() and those of the callback
/// may be called from any thread.
class OwnedEngine
{
public:
    /// \a settings must outlive the engines.
    OwnedEngine(const HapticSettings& settings, OwnerKind kind) : _settings(settings), _kind(kind)
    {
    }

    /// Returns the engine for the node that was played last; null before the first one.
    osg::ref_ptr<HapticEngine> get() const
    {
        const midair::base::Lock lock(_mutex);
        return _engine;
    }

    /// Notes a visit of \a root and returns its engine. \a isInPlace: as of
    /// HapticEngine::setPlace(); \a unmarked: property for an untagged scene, may be null.
    template<typename Place>
    osg::ref_ptr<HapticEngine>
    playing(osg::Node& root, const Place& isInPlace, const HapticProperty* unmarked = nullptr)
    {
        osg::ref_ptr<HapticEngine> engine = get();
        if (!engine || engine->root() != &root)
        {
            osg::ref_ptr<HapticEngine> old = new HapticEngine(root, _settings, _kind);
            if (unmarked) old->setUnmarkedProperty(*unmarked);
            old->setDeviceCallback(_deviceCallback);
            old->setMessageCallback(_messageCallback);
            old->setPlace(isInPlace);
            const midair::base::Lock lock(_mutex);
            old->setMuted(_engine ? _engine->isMuted() : _isMutedAtFirst);
            engine = old;
            _engine.swap(old); // the old one is released outside the lock
        }
        engine->noteVisit();
        return engine;
    }

    /// As HapticScene::setMuted(). The key F8 mutes only the engine.
    void setMuted(bool muted)
    {
        const midair::base::Lock lock(_mutex);
        if (_engine)
            _engine->setMuted(muted);
        else
            _isMutedAtFirst = muted;
    }
    bool isMuted() const
    {
        const midair::base::Lock lock(_mutex);
        return _engine ? _engine->isMuted() : _isMutedAtFirst;
    }

    void setDeviceCallback(DeviceCallback* callback)
    {
        _deviceCallback = callback;
        if (const osg::ref_ptr<HapticEngine> engine = get()) engine->setDeviceCallback(callback);
    }
    DeviceCallback* deviceCallback() const { return _deviceCallback.get(); }

    void setMessageCallback(MessageCallback* callback)
    {
        _messageCallback = callback;
        if (const osg::ref_ptr<HapticEngine> engine = get()) engine->setMessageCallback(callback);
    }
    MessageCallback* messageCallback() const { return _messageCallback.get(); }

    void clearMessages()
    {
        if (const osg::ref_ptr<HapticEngine> engine = get()) engine->clearMessages();
    }

    /// Returns counters and figures. \a whySilent: a message with the reason why nothing is played;
    /// empty: none.
    HapticStatistics statistics(const std::string& whySilent) const
    {
        const osg::ref_ptr<HapticEngine> engine = get();
        HapticStatistics all = engine ? engine->statistics() : HapticStatistics();
        if (whySilent.empty()) return all;
        all.told.push_back(toPublic({midair::base::MessageCode::VIEWER_SILENT, whySilent}));
        all.told.back().isActive = true;
        all.messages.push_back(whySilent);
        return all;
    }

    osg::ref_ptr<const HapticField> field() const
    {
        const osg::ref_ptr<HapticEngine> engine = get();
        return engine ? engine->field() : nullptr;
    }

private:
    const HapticSettings& _settings;
    const OwnerKind _kind;
    osg::ref_ptr<DeviceCallback> _deviceCallback;
    osg::ref_ptr<MessageCallback> _messageCallback;
    mutable midair::base::Mutex _mutex;
    osg::ref_ptr<HapticEngine> _engine MIDAIR_GUARDED_BY(_mutex);
    bool _isMutedAtFirst MIDAIR_GUARDED_BY(_mutex) = false; ///< until there is an engine
};

} // namespace osgMidair
