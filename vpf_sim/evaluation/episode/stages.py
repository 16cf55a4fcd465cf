"""The stages of a step that are timed, by name, each with the place of its function for a `Stopwatch`.

A name with a point is a part of the stage before the point; all other stages lie side by side, and together make up the
step but for the few lines that call them.
"""

STAGES = {
    "render": "vpf_sim.envs.camera.renderer:Renderer.render",
    "render.sky": "vpf_sim.envs.camera.sky.sky:Sky.draw",
    "render.ground": "vpf_sim.envs.camera.ground.ground:Ground.draw",
    "render.haze": "vpf_sim.envs.camera.haze:Haze.ground",
    "render.visible": "vpf_sim.envs.camera.scenery.scene:Scene.visible",
    "render.wet_road": "vpf_sim.envs.camera.rain.wet_road:WetRoad.draw",
    "render.shadows": "vpf_sim.envs.camera.scenery.scene:Scene.paint_shadows",
    "render.scene": "vpf_sim.envs.camera.scenery.scene:Scene.paint",
    "render.streaks": "vpf_sim.envs.camera.rain.streaks:Streaks.draw",
    "render.lens": "vpf_sim.envs.camera.lens:Lens.distorted",
    "render.glass": "vpf_sim.envs.camera.glass.glass:Glass.draw",
    "render.sensor": "vpf_sim.envs.camera.sensor:Sensor.expose",
    "skip": "vpf_sim.envs.camera.renderer:Renderer.skip",  # a frame that the driver does not use
    "physics": "vpf_sim.envs.four_lane:FourLane.advance",
    "ending": "vpf_sim.envs.ending:Ending.status",
    "observation": "vpf_sim.envs.four_lane:FourLane._observation",
    "info": "vpf_sim.envs.four_lane:FourLane._info",
    "grey": "vpf_sim.planning.planner:grey",
    "flow": "vpf_sim.perception.egomotion.flow:FlowTracker.update",
    "derotation": "vpf_sim.perception.egomotion.focus_of_expansion:derotated",
    "foe": "vpf_sim.perception.egomotion.focus_of_expansion:estimate",
    "steadiness": "vpf_sim.perception.egomotion.camera_pitch:PitchEstimator.update",
    "steadiness_frames": "vpf_sim.perception.egomotion.camera_pitch:PitchEstimator.frame",
    "road": "vpf_sim.perception.road.edge_tracker:RoadEdgeTracker.update",
    "contrast": "vpf_sim.planning.planner:contrast",
    "look": "vpf_sim.perception.obstacles.static_tracker:StaticObstacleTracker.look",
    "bodies": "vpf_sim.planning.planner:Planner._find_bodies",
    "bodies.triangulation": "vpf_sim.perception.obstacles.static_tracker:StaticObstacleTracker.triangulate",
    "bodies.movers": "vpf_sim.perception.obstacles.moving.tracker:MovingObstacleTracker.update",
    "bodies.landmarks": "vpf_sim.perception.obstacles.static_tracker:StaticObstacleTracker.update",
    "bodies.sharpened": "vpf_sim.perception.obstacles.static_tracker:StaticObstacleTracker.refined",
    "second_look": "vpf_sim.perception.obstacles.close_range_verification:CloseRangeVerifier.update",
    "carried": "vpf_sim.planning.planner:Planner._carried",
    "plan": "vpf_sim.planning.planner:Planner.plan",
    "control": "vpf_sim.controllers.gtsmc:Gtsmc.command",
}
IN_EPISODES = {
    **STAGES,
    "world": "vpf_sim.envs.four_lane:FourLane.step",  # render up to info are parts of it
    "driver": "vpf_sim.drivers:command_of",  # and what comes after them of this
    "log": "vpf_sim.evaluation.episode.log:StepLog.observe",
}
