"""The dashboard as a process of its own: ``python serving_child.py ROUTER_PORT PAGE_PORT``, or a router."""

import sys

from closed_form import paper_scenario
from passafe_dashboard.process import serve
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.router.process import run_router

if __name__ == "__main__":
    router_port, page_port = sys.argv[1:]
    if page_port == "router":
        run_router(RouterEndpoint(port=int(router_port)), lifeline=True)
    else:
        reason = serve(RouterEndpoint(port=int(router_port)), int(page_port), scenario=paper_scenario(), lifeline=True)
        sys.stdout.write(f"ended by {reason.name if reason else None}\n")
