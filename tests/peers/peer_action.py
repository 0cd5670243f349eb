#!/usr/bin/env python3
"""Sends an action a goal as a Cyclone DDS peer, as `ros2 action send_goal --feedback` does.

    peer_action.py --domain 0 /auv/depth_controller/manoeuvre planesman_msgs/action/Manoeuvre \\
        --json '{"name": "run_8_1"}' --cancel-after 3

Prints one JSON line when the goal is accepted or rejected, one for each feedback, and one for its end, with the
states that the status topic gave it. Exit status 1: the node did not answer within --timeout seconds. 3: rejected.
"""

import sys
import threading
import time
import uuid

import arguments
import ros_types
from cyclone import Peer, dds_topic_name, topic_qos
from ros_service import Client, NoAnswer

REJECTED = 3


def status_names() -> dict[int, str]:
    """GoalStatus' number -> `SUCCEEDED` and so on."""
    constants = ros_types.constants("action_msgs/msg/GoalStatus")
    return {number: name.removeprefix("STATUS_") for name, number in constants.items()}


def main() -> int:
    args = arguments.action(__doc__)

    peer = Peer(args.domain)
    below = f"{args.action}/_action"
    feedback_type = f"{args.type}_FeedbackMessage"
    feedback = peer.reader(
        dds_topic_name(f"{below}/feedback"), ros_types.message(feedback_type), topic_qos()
    )
    status_type = "action_msgs/msg/GoalStatusArray"
    statuses = peer.reader(
        dds_topic_name(f"{below}/status"),
        ros_types.message(status_type),
        topic_qos(durability="transient_local", depth=100),
    )
    send = Client(peer, f"{below}/send_goal", f"{args.type}_SendGoal")
    result = Client(peer, f"{below}/get_result", f"{args.type}_GetResult")
    cancel = Client(peer, f"{below}/cancel_goal", "action_msgs/srv/CancelGoal")
    goal_id = {"uuid": list(uuid.uuid4().bytes)}
    names = status_names()
    seen = []

    def listen() -> None:
        for sample in feedback.take(N=100):
            told = ros_types.to_json(feedback_type, sample)
            if list(told["goal_id"]["uuid"]) == goal_id["uuid"]:
                arguments.show(feedback=told["feedback"])
        for sample in statuses.take(N=100):
            for status in ros_types.to_json(status_type, sample)["status_list"]:
                ours = list(status["goal_info"]["goal_id"]["uuid"]) == goal_id["uuid"]
                name = names[status["status"]]
                if ours and seen[-1:] != [name]:
                    seen.append(name)

    try:
        request = {"goal_id": goal_id, "goal": args.json}
        accepted = send.call(request, args.timeout)["accepted"]
        arguments.show(accepted=accepted)
        if not accepted:
            return REJECTED
        end: dict = {}

        def wait_for_result() -> None:
            end.update(result.call({"goal_id": goal_id}, args.timeout))

        waiting = threading.Thread(target=wait_for_result, daemon=True)
        waiting.start()
        cancel_at = time.monotonic() + (args.cancel_after or args.timeout)
        while waiting.is_alive():
            listen()
            if args.cancel_after and time.monotonic() >= cancel_at:
                args.cancel_after = None
                arguments.show(cancel=cancel.call({"goal_info": {"goal_id": goal_id}}, args.timeout)["return_code"])
            time.sleep(0.01)
        if not end:
            raise NoAnswer(f"{args.action}: no result within {args.timeout:g} s")
        deadline = time.monotonic() + 5.0
        while seen[-1:] != [names[end["status"]]] and time.monotonic() < deadline:
            listen()
            time.sleep(0.01)
        arguments.show(status=names[end["status"]], result=end["result"], statuses=seen)
    except NoAnswer as failure:
        print(failure, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
